//! Vector plots and self-contained HTML.
