//! Samples as little-endian bytes, readable from any language.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, SeqAccess, Visitor};
use serde::ser::Serializer;

/// A sample type.
pub(crate) trait Sample: Copy + for<'de> Deserialize<'de> {
    /// The bytes of these samples.
    fn to_bytes(samples: &[Self]) -> Vec<u8>;
    /// Decodes samples; trailing bytes are ignored.
    fn from_bytes(bytes: &[u8]) -> Vec<Self>;
}

impl Sample for u8 {
    fn to_bytes(samples: &[Self]) -> Vec<u8> {
        samples.to_vec()
    }

    fn from_bytes(bytes: &[u8]) -> Vec<Self> {
        bytes.to_vec()
    }
}

impl Sample for f32 {
    fn to_bytes(samples: &[Self]) -> Vec<u8> {
        samples.iter().flat_map(|x| x.to_le_bytes()).collect()
    }

    fn from_bytes(bytes: &[u8]) -> Vec<Self> {
        bytes.as_chunks::<4>().0.iter().map(|x| Self::from_le_bytes(*x)).collect()
    }
}

pub(crate) fn serialize<T: Sample, S: Serializer>(samples: &[T], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bytes(&T::to_bytes(samples))
}

/// Deserialises bytes, or a list of numbers, which is easier to write in other languages.
pub(crate) fn deserialize<'de, T: Sample, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
    struct Samples<T>(PhantomData<T>);
    impl<'de, T: Sample> Visitor<'de> for Samples<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("samples, as bytes or as a list of numbers")
        }

        fn visit_bytes<E>(self, bytes: &[u8]) -> Result<Vec<T>, E> {
            Ok(T::from_bytes(bytes))
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
            // Memory is allocated as numbers arrive, not from the claimed length.
            let mut samples = Vec::new();
            while let Some(sample) = list.next_element()? {
                samples.push(sample);
            }
            Ok(samples)
        }
    }
    deserializer.deserialize_any(Samples(PhantomData))
}
