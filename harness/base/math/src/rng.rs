//! Seeded random streams, counter-based: a stream is named by a seed and a path of labels, so what one consumer
//! draws never depends on how much another drew before it.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

/// A random stream (ChaCha8). Distributions are computed here, not by a library, so that an update of a
/// dependency can't change what a seed means.
#[derive(Clone, Debug)]
pub struct Stream(ChaCha8Rng);

/// SplitMix64's finaliser (Steele, Lea, Flood 2014, fig. 15), used to mix a seed and labels into a key.
fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Stream {
    /// The stream named by `seed` and `labels`, e.g. `Stream::new(7, &["world", "w003", "obstacles"])`.
    #[must_use]
    pub fn new(seed: u64, labels: &[&str]) -> Self {
        let mut h = mix(seed);
        for label in labels {
            h = mix(h ^ label.len() as u64);
            for b in label.bytes() {
                h = mix(h ^ u64::from(b));
            }
        }
        let mut key = [0u8; 32];
        for chunk in key.chunks_exact_mut(8) {
            h = mix(h);
            chunk.copy_from_slice(&h.to_le_bytes());
        }
        Self(ChaCha8Rng::from_seed(key))
    }

    /// Where the stream stands: its key, and how many words of 32 bits were drawn.
    #[must_use]
    pub fn position(&self) -> ([u8; 32], u128) {
        (self.0.get_seed(), self.0.get_word_pos())
    }

    /// The stream that stands at a [`Self::position`].
    #[must_use]
    pub fn at_position(key: [u8; 32], words: u128) -> Self {
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_word_pos(words);
        Self(rng)
    }

    /// 64 uniform bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in [0, 1), on the grid of 2⁻⁵³.
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in [low, high).
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform integer in 0..n (n > 0), without modulo bias (Lemire 2019).
    pub fn below(&mut self, n: u64) -> u64 {
        assert!(n > 0, "below(0) has no value");
        let threshold = n.wrapping_neg() % n;
        loop {
            let m = u128::from(self.next_u64()) * u128::from(n);
            if m as u64 >= threshold {
                return (m >> 64) as u64;
            }
        }
    }

    /// Normal with the given mean and standard deviation (Box–Muller; one value a call keeps streams simple).
    pub fn normal(&mut self, mean: f64, std: f64) -> f64 {
        let u = 1.0 - self.unit();
        let v = self.unit();
        mean + std * (-2.0 * crate::ln(u)).sqrt() * crate::cos(std::f64::consts::TAU * v)
    }

    /// A uniformly random order of the slice (Fisher–Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i as u64 + 1) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_depends_on_its_seed_and_its_labels_only() {
        let draw = |s: u64, l: &[&str]| Stream::new(s, l).next_u64();
        assert_eq!(draw(1, &["a", "b"]), draw(1, &["a", "b"]));
        assert_ne!(draw(1, &["a", "b"]), draw(2, &["a", "b"]));
        assert_ne!(draw(1, &["a", "b"]), draw(1, &["ab"]));
        assert_ne!(draw(1, &["a", "b"]), draw(1, &["b", "a"]));
    }

    #[test]
    fn a_stream_goes_on_from_its_position() {
        let mut stream = Stream::new(7, &["a"]);
        for _ in 0..37 {
            stream.next_u64();
        }
        let (key, words) = stream.position();
        let mut other = Stream::at_position(key, words);
        assert_eq!(words, 74);
        assert!((0..100).all(|_| stream.next_u64() == other.next_u64()));
    }

    #[test]
    fn moments_are_those_of_the_named_distributions() {
        // Mean and variance of U[2, 5): 3.5, 9/12; of N(1, 2): 1, 4. Bounds: five standard errors at n = 40 000.
        let n = 40_000;
        let mut s = Stream::new(3, &["moments"]);
        let u: Vec<f64> = (0..n).map(|_| s.uniform(2.0, 5.0)).collect();
        let g: Vec<f64> = (0..n).map(|_| s.normal(1.0, 2.0)).collect();
        let mean = |v: &[f64]| v.iter().sum::<f64>() / n as f64;
        let var = |v: &[f64], m: f64| v.iter().map(|x| (x - m) * (x - m)).sum::<f64>() / n as f64;
        assert!((mean(&u) - 3.5).abs() < 0.022);
        assert!((var(&u, 3.5) - 0.75).abs() < 0.02);
        assert!((mean(&g) - 1.0).abs() < 0.05);
        assert!((var(&g, 1.0) - 4.0).abs() < 0.15);
    }

    #[test]
    fn below_reaches_every_value_and_no_other() {
        let mut s = Stream::new(5, &["below"]);
        let mut seen = [0u32; 7];
        for _ in 0..7000 {
            seen[s.below(7) as usize] += 1;
        }
        assert!(seen.iter().all(|&c| (800..1200).contains(&c)), "{seen:?}");
    }
}
