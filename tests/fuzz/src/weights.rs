//! Learned weights, which a planner's author brings.

use vb_sdk::nn::{Layer, Weights};

/// Networks of more are not run: a target is to be quick.
const MOST: usize = 1 << 16;

/// Reads a file. What is accepted can be written and read again, and its networks run.
pub(crate) fn run(data: &[u8]) {
    let Ok(weights) = Weights::parse(data) else { return };
    let again = Weights::parse(&weights.bytes());
    assert_eq!(again.as_ref(), Ok(&weights));
    for layer in &weights.layers {
        let (inputs, outputs) = (layer.shape.inputs(), layer.shape.outputs());
        if layer.shape.multiplications() < MOST && inputs.max(outputs) < MOST {
            let _ = weights.network(&layer.name, inputs, outputs);
            let _ = weights.fixed_network(&layer.name, &[inputs], outputs);
        }
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let layer = |name: &str, inputs, outputs: usize| {
        let weights = (0..inputs * outputs).map(|k| k as f32 * 0.25 - 1.0).collect();
        Layer::dense(name, inputs, weights, vec![0.5; outputs])
    };
    let notes = vec![("seed".to_owned(), "7".to_owned())];
    let layers = vec![layer("a.0", 3, 4), layer("a.1", 4, 2)];
    let convolution = "vb-nn: 1\nconvolution: c.0 1 4 4 2 3 1 1\n\n";
    let numbers = (0..2 * 9 + 2).flat_map(|k| (k as f32).to_le_bytes());
    vec![
        Weights { notes, layers }.bytes(),
        Weights::default().bytes(),
        convolution.bytes().chain(numbers).collect(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seeds_are_weights() {
        for seed in seeds() {
            Weights::parse(&seed).expect("weights");
        }
    }
}
