//! What recordings of made-up specimens are said to be, from the file to the answer: one program, since each takes the linker a second.

mod bonded;
mod fresh_specimens;
mod holds;
mod hum;
mod inexact_laws;
mod louder_noise;
mod outliers;
mod scattered_displacement;
mod slow_signal;
mod stairs;
mod strong_effects;
mod taps;
mod touch;
mod unknown_past;
mod without_rest;
