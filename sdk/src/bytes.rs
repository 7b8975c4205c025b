//! Samples as bytes, least significant first, so that any language reads a map or a scan at once.

use serde::{Deserialize as _, Deserializer, Serializer};

/// A kind of sample.
pub(crate) trait Sample: Copy {
    /// The bytes of these samples.
    fn to_bytes(samples: &[Self]) -> Vec<u8>;
    /// The samples of these bytes; what is left at the end is dropped.
    fn from_bytes(bytes: Vec<u8>) -> Vec<Self>;
}

impl Sample for u8 {
    fn to_bytes(samples: &[Self]) -> Vec<u8> {
        samples.to_vec()
    }

    fn from_bytes(bytes: Vec<u8>) -> Vec<Self> {
        bytes
    }
}

impl Sample for f32 {
    fn to_bytes(samples: &[Self]) -> Vec<u8> {
        samples.iter().flat_map(|x| x.to_le_bytes()).collect()
    }

    fn from_bytes(bytes: Vec<u8>) -> Vec<Self> {
        bytes.as_chunks::<4>().0.iter().map(|x| Self::from_le_bytes(*x)).collect()
    }
}

pub(crate) fn serialize<T: Sample, S: Serializer>(samples: &[T], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bytes(&T::to_bytes(samples))
}

pub(crate) fn deserialize<'de, T: Sample, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
    serde_bytes::ByteBuf::deserialize(deserializer).map(|bytes| T::from_bytes(bytes.into_vec()))
}
