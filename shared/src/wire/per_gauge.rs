//! One value for each gauge, on the line as many as the sender has.

use core::fmt;
use core::marker::PhantomData;
use core::ops::{Deref, DerefMut};

use postcard_schema::Schema;
use postcard_schema::schema::{DataModelType, NamedType};
use serde::de::{Deserialize, Deserializer, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};

use crate::pipeline::GAUGES;

/// Gauges of every device of release 0.1.
pub(super) const FOUR: usize = 4;

/// One value for each gauge. On the line it is a list with its length in front, so that devices with another number of gauges speak the
/// same messages: what a shorter list lacks is the default, what a longer one has beyond is left out. How many gauges a device has it says
/// in its `Hello`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct PerGauge<T>(pub [T; GAUGES]);

impl<T> Deref for PerGauge<T> {
    type Target = [T; GAUGES];

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<T> DerefMut for PerGauge<T> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl<T: PartialEq> PartialEq<[T; GAUGES]> for PerGauge<T> {
    fn eq(&self, other: &[T; GAUGES]) -> bool {
        self.0 == *other
    }
}

impl<T: Copy + Default> PerGauge<T> {
    /// Of those of another number of gauges: what there are more of is left out, what is missing is the default.
    pub(super) fn of(values: &[T]) -> Self {
        Self(resized(values))
    }

    /// Those of the first four, as release 0.1 says them.
    pub(super) fn four(&self) -> [T; FOUR] {
        resized(&self.0)
    }
}

fn resized<T: Copy + Default, const N: usize>(values: &[T]) -> [T; N] {
    core::array::from_fn(|gauge| values.get(gauge).copied().unwrap_or_default())
}

impl<T: Serialize> Serialize for PerGauge<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.as_slice().serialize(serializer)
    }
}

impl<'de, T: Deserialize<'de> + Copy + Default> Deserialize<'de> for PerGauge<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(List(PhantomData))
    }
}

impl<T: Schema> Schema for PerGauge<T> {
    const SCHEMA: &'static NamedType =
        &NamedType { name: "PerGauge", ty: &DataModelType::Seq(T::SCHEMA) };
}

struct List<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Copy + Default> Visitor<'de> for List<T> {
    type Value = PerGauge<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list with a value for each gauge")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut values = PerGauge::default();
        let mut places = values.iter_mut();
        while let Some(value) = list.next_element()? {
            if let Some(place) = places.next() {
                *place = value;
            }
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Option<[u8; GAUGES]> {
        postcard::from_bytes::<PerGauge<u8>>(bytes).ok().map(|values| values.0)
    }

    #[test]
    fn lists_of_any_number_of_gauges_are_read() {
        let mut room = [0; 8];
        let sent = postcard::to_slice(&PerGauge([1_u8, 2, 3, 4]), &mut room).unwrap();
        assert_eq!(sent, [4, 1, 2, 3, 4]);
        assert_eq!(read(sent), Some([1, 2, 3, 4]));
        assert_eq!(read(&[1, 7]), Some([7, 0, 0, 0]));
        assert_eq!(read(&[0]), Some([0; 4]));
        assert_eq!(read(&[5, 1, 2, 3, 4, 5]), Some([1, 2, 3, 4]));
        assert_eq!(read(&[4, 1, 2, 3]), None, "cut off");
    }

    #[test]
    fn what_is_said_to_release_0_1_is_of_four() {
        assert_eq!(PerGauge([1, 2, 3, 4]).four(), [1, 2, 3, 4]);
        assert_eq!(PerGauge::of(&[5]), PerGauge([5, 0, 0, 0]));
    }
}
