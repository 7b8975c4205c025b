//! What a file is told apart by.

use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;

/// A SHA-256 over parts, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Hash(Sha256);

impl Hash {
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a part. Two parts hash as one that is both: who needs to tell them apart adds their lengths.
    pub fn update(&mut self, part: impl AsRef<[u8]>) {
        self.0.update(part);
    }

    /// The hash as 64 hexadecimal digits, lower case.
    #[must_use]
    pub fn hex(self) -> String {
        self.0.finalize().iter().fold(String::with_capacity(64), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
    }
}

/// The SHA-256 of bytes as 64 hexadecimal digits, lower case.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    let mut hash = Hash::new();
    hash.update(bytes);
    hash.hex()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hash_is_that_of_the_standard() {
        // FIPS 180-4's example of one block, "abc" (NIST, Cryptographic Standards and Guidelines, SHA256.pdf).
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), expected);
        let mut parts = Hash::new();
        parts.update("a");
        parts.update("bc");
        assert_eq!(parts.hex(), expected);
    }
}
