//! What the whole-product tests share: the binary under test and the folders they read.
