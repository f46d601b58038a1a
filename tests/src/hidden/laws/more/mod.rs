//! Further laws, each as unlike the forms of the library as its physics allows, and further
//! disturbances that no effect of the library describes. They have groups of their own, so that
//! figures of the others stay comparable.

pub mod contact;
pub mod elastic;
pub mod motion;
pub mod rare;
pub mod relaxation;
pub mod sensor;
