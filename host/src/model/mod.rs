//! Base laws and the model file.
