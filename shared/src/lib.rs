//! What the palpate fingertip and its host must agree on.
#![no_std]
#![forbid(unsafe_code)]
