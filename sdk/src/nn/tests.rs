//! Networks against sums by hand.

use super::*;

fn layer(name: &str, inputs: usize, weights: &[f32], bias: &[f32]) -> Layer {
    Layer { name: name.into(), inputs, outputs: bias.len(), weights: weights.to_vec(), bias: bias.to_vec() }
}

/// Two inputs, two hidden values, one output.
fn weights() -> Weights {
    let layers = vec![
        layer("net.0", 2, &[1.0, 2.0, -1.0, 0.5], &[0.5, -0.25]),
        layer("net.1", 2, &[2.0, 4.0], &[1.0]),
    ];
    Weights { notes: vec![("trained on".into(), "hills: and vales".into())], layers }
}

#[test]
fn a_network_is_its_sums_with_leaky_rectifiers_between() {
    let network = weights().network("net", 2, 1).unwrap();
    assert_eq!((network.inputs(), network.outputs(), network.multiplications()), (2, 1, 6));
    let input = [std::array::from_fn(|l| l as f32), [3.0; LANES]];
    let mut output = [[0.0; LANES]];
    network.run(&input, &mut output, &mut Scratch::default());
    for (l, value) in output[0].into_iter().enumerate() {
        let x = l as f32;
        let hidden = [x + 6.0 + 0.5, -x + 1.5 - 0.25].map(|v| if v < 0.0 { 0.1 * v } else { v });
        // All of these are small binary fractions but the leak's.
        assert!((value - (2.0 * hidden[0] + 4.0 * hidden[1] + 1.0)).abs() < 1e-5, "{l}: {value}");
    }
}

#[test]
fn each_output_of_a_wide_layer_is_the_sum_of_its_own_row() {
    let weights: Vec<f32> = (0..6 * 3).map(|k| (k * k % 17) as f32 - 8.0).collect();
    let bias = [1.0, -2.0, 3.0, -4.0, 5.0, -6.0];
    let network = Network::new(vec![layer("wide.0", 3, &weights, &bias)]).unwrap();
    let input: [Lanes; 3] = std::array::from_fn(|i| std::array::from_fn(|l| (i * LANES + l) as f32));
    let mut output = [[0.0; LANES]; 6];
    network.run(&input, &mut output, &mut Scratch::default());
    for (k, values) in output.iter().enumerate() {
        let sum = |l: usize| bias[k] + (0..3).map(|i| weights[3 * k + i] * input[i][l]).sum::<f32>();
        // Whole numbers: exact in any order.
        assert_eq!(*values, std::array::from_fn::<f32, LANES, _>(sum), "output {k}");
    }
}

#[test]
fn what_is_written_is_read_again() {
    let own = weights();
    let bytes = own.bytes();
    let again = Weights::parse(&bytes).unwrap();
    assert_eq!(again, own);
    assert_eq!(again.note("trained on"), Some("hills: and vales"));
    assert_eq!(again.bytes(), bytes);
}

#[test]
fn what_can_not_be_used_is_refused_with_its_reason() {
    let bytes = weights().bytes();
    let refused = |bytes: &[u8], says: &str| {
        let e = Weights::parse(bytes).unwrap_err().to_string();
        assert!(e.contains(says), "{e}");
    };
    refused(&bytes[..bytes.len() - 4], "layer net.1 is cut off");
    refused(&[&bytes[..], &[0; 4]].concat(), "more numbers than the layers have");
    refused(&[&bytes[..], &[0]].concat(), "more numbers than the layers have");
    refused(b"vb-nn: 1\nlayer: a 1 1", "no empty line");
    refused(b"vb-nn: 2\n\n", "format 2 is not supported (only 1 is)");
    refused(b"PK\x03\x04: x\n\n", "these are no weights");
    refused(b"vb-nn: 1\nlayer: a 0 1\n\n", "layer \"a 0 1\" is not");
    refused(b"vb-nn: 1\nlayer: a 3000000 3000000\n\n", "more than");
    let mut other = weights();
    other.layers[1].weights[1] = f32::NAN;
    refused(&other.bytes(), "layer net.1: number 1 is NaN");
    let own = weights();
    let refused = |name: &str, inputs, outputs, says: &str| {
        let e = own.network(name, inputs, outputs).unwrap_err().to_string();
        assert!(e.contains(says), "{e}");
    };
    refused("other", 2, 1, "there is no network other");
    refused("net", 3, 1, "net turns 2 inputs into 1 outputs, and not 3 into 1");
    let mut other = weights();
    other.layers[1].inputs = 1;
    assert!(other.network("net", 2, 1).unwrap_err().to_string().contains("don't fit together"));
}
