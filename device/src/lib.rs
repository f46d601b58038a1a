//! What the fingertip does, without its hardware.
