//! Converters that a fingertip may have.

mod four_channels;

pub use four_channels::FourChannels;
