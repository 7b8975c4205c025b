//! CDR as bags and DDS have it: four bytes that say which encoding it is, then plain CDR (XCDR1).

use byteorder::{BigEndian, LittleEndian};
use cdr_encoding::{from_bytes, to_vec};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The header of plain CDR in little-endian byte order: representation identifier and options (RTPS 2.5, 10.2.1.2).
const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];
const BIG_ENDIAN: [u8; 4] = [0, 0, 0, 0];
const HEADER: usize = 4;

/// The reason why bytes are not the message that they should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// There are fewer bytes than the header has.
    #[error("{0} bytes, which is less than the header of 4 bytes")]
    Short(usize),
    /// The encoding is another one, such as XCDR2 or a parameter list.
    #[error("the encoding 0x{0:02x}{1:02x} is not plain CDR (0x0000 or 0x0001)")]
    Encoding(u8, u8),
    /// The bytes after the header do not fit the type.
    #[error("{0}")]
    Malformed(String),
}

/// A message as little-endian CDR with its header.
///
/// # Errors
/// Returns an error if a sequence or text is longer than 2³² − 1.
pub fn to_cdr(message: &impl Serialize) -> Result<Vec<u8>, CdrError> {
    let body = to_vec::<_, LittleEndian>(message).map_err(|e| CdrError::Malformed(e.to_string()))?;
    let mut bytes = Vec::with_capacity(HEADER + body.len());
    bytes.extend(LITTLE_ENDIAN);
    bytes.extend(body);
    Ok(bytes)
}

/// Reads a message from CDR with its header, in either byte order. Bytes after the message are ignored: they may be padding.
///
/// # Errors
/// Returns an error if the bytes are not a message of this type.
pub fn from_cdr<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CdrError> {
    let Some((header, body)) = bytes.split_first_chunk::<HEADER>() else {
        return Err(CdrError::Short(bytes.len()));
    };
    let read = match [header[0], header[1]] {
        [a, b] if [a, b] == LITTLE_ENDIAN[..2] => from_bytes::<T, LittleEndian>(body),
        [a, b] if [a, b] == BIG_ENDIAN[..2] => from_bytes::<T, BigEndian>(body),
        [a, b] => return Err(CdrError::Encoding(a, b)),
    };
    read.map(|(message, _)| message).map_err(|e| CdrError::Malformed(e.to_string()))
}
