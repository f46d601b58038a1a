//! Set-up, the whole check, generated recordings.

fn main() {}
