//! Messages of any type, as the bytes that they are on the wire: for those who record and replay.
//!
//! The DDS library hands payloads to serde alone. So a raw message reads bytes until there are no
//! more, and writes them as they are; which order of bytes they have is told by the type of the
//! decoder, and a test holds that it is.

use std::fmt;

use serde::de::{Deserialize, Deserializer, SeqAccess, Visitor};
use serde::ser::{Serialize, SerializeTuple, Serializer};

/// What precedes a payload of either order: the lowest byte first, or last.
const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];
const BIG_ENDIAN: [u8; 4] = [0, 0, 0, 0];

/// A payload with its encapsulation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raw(pub Vec<u8>);

impl Raw {
    /// The payload of a bag, if it can be sent as it is.
    pub fn of(payload: Vec<u8>) -> Option<Self> {
        payload.starts_with(&LITTLE_ENDIAN[..2]).then_some(Self(payload))
    }
}

impl ros2_client::Message for Raw {}

impl Serialize for Raw {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let body = self.0.get(LITTLE_ENDIAN.len()..).unwrap_or_default();
        let mut tuple = serializer.serialize_tuple(body.len())?;
        body.iter().try_for_each(|byte| tuple.serialize_element(byte))?;
        tuple.end()
    }
}

impl<'de> Deserialize<'de> for Raw {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let is_big = std::any::type_name::<D>().contains("BigEndian");
        let head = if is_big { BIG_ENDIAN } else { LITTLE_ENDIAN };
        deserializer.deserialize_tuple(usize::MAX, Bytes(head.to_vec()))
    }
}

struct Bytes(Vec<u8>);

impl<'de> Visitor<'de> for Bytes {
    type Value = Raw;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("bytes")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut bytes: A) -> Result<Raw, A::Error> {
        // The end of the payload is an error to the decoder.
        while let Ok(Some(byte)) = bytes.next_element::<u8>() {
            self.0.push(byte);
        }
        Ok(Raw(self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_go_through_as_they_are_and_tell_their_order() {
        let body: Vec<u8> = (0..=255).collect();
        let little = cdr_encoding::from_bytes::<Raw, byteorder::LittleEndian>(&body);
        let big = cdr_encoding::from_bytes::<Raw, byteorder::BigEndian>(&body);
        let payload = |head: [u8; 4]| Raw([head.to_vec(), body.clone()].concat());
        assert_eq!(little.ok().map(|(raw, _)| raw), Some(payload(LITTLE_ENDIAN)));
        assert_eq!(big.ok().map(|(raw, _)| raw), Some(payload(BIG_ENDIAN)));
        let sent = cdr_encoding::to_vec::<Raw, byteorder::LittleEndian>(&payload(LITTLE_ENDIAN));
        assert_eq!(sent.ok(), Some(body.clone()));
        assert_eq!(Raw::of(payload(BIG_ENDIAN).0), None);
    }
}
