//! A hash over a trajectory, by which two runs are compared bit for bit.

/// The time between two samples of the state, of which hashes and traces are made, s.
pub const SAMPLE_PERIOD: f64 = 0.01;

/// An FNV-1a hash over 64-bit words with a final mix. It is no defence against forgery; it shows differences.
#[derive(Clone, Debug)]
pub struct StateHash(u64);

impl Default for StateHash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl StateHash {
    /// Adds the bits of a number to the hash. Zero and minus zero differ.
    pub fn push(&mut self, value: f64) {
        // FNV's prime leaves the upper bits of a word poorly spread, hence the rotation.
        self.0 = (self.0 ^ value.to_bits()).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29);
    }

    #[must_use]
    pub fn value(&self) -> u64 {
        let mixed = (self.0 ^ (self.0 >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        mixed ^ (mixed >> 33)
    }

    /// The hash as 16 hexadecimal digits.
    #[must_use]
    pub fn hex(&self) -> String {
        format!("{:016x}", self.value())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hash(values: &[f64]) -> String {
        let mut h = StateHash::default();
        values.iter().for_each(|&v| h.push(v));
        h.hex()
    }

    #[test]
    fn one_bit_or_the_order_changes_the_hash() {
        let a = hash(&[1.0, 2.0, 3.0]);
        assert_eq!(a, hash(&[1.0, 2.0, 3.0]));
        assert_eq!(a.len(), 16);
        assert_ne!(a, hash(&[1.0, 2.0, 3.0000000000000004]));
        assert_ne!(a, hash(&[2.0, 1.0, 3.0]));
        assert_ne!(hash(&[0.0]), hash(&[-0.0]));
        assert_ne!(hash(&[1.0, 0.0]), hash(&[1.0]));
    }
}
