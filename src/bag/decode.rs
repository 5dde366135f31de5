//! Payloads to messages and back: CDR as ROS 2 stores it, in either order of bytes.
//!
//! The payload may be anything: it is a message or an error.

use byteorder::{BigEndian, LittleEndian};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Bytes before the message: which encoding it has.
const ENCAPSULATION_BYTES: usize = 4;
/// Encodings: plain CDR, the highest byte first or last.
const CDR_BIG_ENDIAN: [u8; 2] = [0, 0];
const CDR_LITTLE_ENDIAN: [u8; 2] = [0, 1];
/// Bytes that may follow the message to round its length up.
const PADDING_MAX: usize = 7;

/// Why a payload is not the message that it should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadPayload {
    /// It has no room for the encapsulation.
    #[error("{0} bytes are no message")]
    Short(usize),
    /// Another encoding than plain CDR.
    #[error("encoding {0:#06x} is not plain CDR (0x0000 or 0x0001)")]
    Encoding(u16),
    /// It does not have the fields of the type.
    #[error("is not of its type: {0}")]
    Type(String),
    /// More than the fields of the type.
    #[error("is not of its type: {0} bytes are left over")]
    Long(usize),
}

/// The message that a payload holds.
///
/// # Errors
/// [`BadPayload`].
pub fn message<M: DeserializeOwned>(payload: &[u8]) -> Result<M, BadPayload> {
    let Some((head, body)) = payload.split_first_chunk::<ENCAPSULATION_BYTES>() else {
        return Err(BadPayload::Short(payload.len()));
    };
    let decoded = match [head[0], head[1]] {
        CDR_LITTLE_ENDIAN => cdr_encoding::from_bytes::<M, LittleEndian>(body),
        CDR_BIG_ENDIAN => cdr_encoding::from_bytes::<M, BigEndian>(body),
        other => return Err(BadPayload::Encoding(u16::from_be_bytes(other))),
    };
    let (message, used) = decoded.map_err(|error| BadPayload::Type(error.to_string()))?;
    match body.len().saturating_sub(used) {
        0..=PADDING_MAX => Ok(message),
        left => Err(BadPayload::Long(left)),
    }
}

/// The payload of a message, the lowest byte first.
///
/// # Errors
/// [`BadPayload::Type`] of a type that CDR does not have.
pub fn payload<M: Serialize>(message: &M) -> Result<Vec<u8>, BadPayload> {
    let mut payload = Vec::new();
    payload_into(message, &mut payload)?;
    Ok(payload)
}

/// The same, behind what is there already.
///
/// # Errors
/// As of [`payload`].
pub fn payload_into<M: Serialize>(message: &M, into: &mut Vec<u8>) -> Result<(), BadPayload> {
    into.extend_from_slice(&[CDR_LITTLE_ENDIAN[0], CDR_LITTLE_ENDIAN[1], 0, 0]);
    cdr_encoding::to_writer::<M, LittleEndian, _>(into, message)
        .map_err(|error| BadPayload::Type(error.to_string()))
}
