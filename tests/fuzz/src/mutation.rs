//! Mutations of seeds, for tests without libFuzzer.

/// The next number of a stream (SplitMix64; Steele, Lea, Flood 2014): the choice of mutations is the same in every run.
pub fn next(state: &mut u64) -> usize {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as usize
}

/// A seed with one to four mutations: bytes changed, left out, repeated, or replaced by a token. Its first byte, which selects what the
/// input stands for, stays.
#[must_use]
pub fn mutate(seed: &[u8], random: &mut u64) -> Vec<u8> {
    /// Numbers and signs that readers stumble over.
    const TOKENS: [&[u8]; 12] = [
        b"-1",
        b"1e308",
        b"NaN",
        b".inf",
        b"0",
        b"99999999999999999999",
        b"\xff\xff\xff\xff",
        b"\0",
        b"[[[[[[[[",
        b"&a *a",
        b"../..",
        b"\xe2\x80\xae",
    ];
    let mut bytes = seed.to_vec();
    for _ in 0..1 + next(random) % 4 {
        let at = next(random) % bytes.len().max(1);
        match next(random) % 6 {
            0 => bytes.truncate(at),
            1 if at < bytes.len() => bytes[at] ^= 1 << (next(random) % 8),
            2 if at < bytes.len() => bytes[at] = next(random) as u8,
            3 => {
                let end = (at + next(random) % 64).min(bytes.len());
                let copy = bytes[at.min(end)..end].to_vec();
                let to = next(random) % (bytes.len() + 1);
                bytes.splice(to..to, copy);
            }
            4 => {
                let end = (at + next(random) % 16).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            _ => {
                let token = TOKENS[next(random) % TOKENS.len()];
                let end = (at + token.len()).min(bytes.len());
                bytes.splice(at.min(end)..end, token.iter().copied());
            }
        }
    }
    // What the input stands for is not the reader's affair.
    if let (Some(kind), Some(first)) = (seed.first(), bytes.first_mut()) {
        *first = *kind;
    }
    bytes
}
