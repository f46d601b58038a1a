//! Converters that a fingertip may have.

mod four_channels;
mod one_channel;

pub use four_channels::FourChannels;
pub use one_channel::OneChannel;
