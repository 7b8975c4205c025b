//! Compares networks with manual sums.

use super::*;

fn layer(name: &str, inputs: usize, weights: &[f32], bias: &[f32]) -> Layer {
    Layer::dense(name, inputs, weights.to_vec(), bias.to_vec())
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
        // All values except those after the leak are small binary fractions.
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
    refused(&bytes[..bytes.len() - 4], "layer net.1 is truncated");
    refused(&[&bytes[..], &[0; 4]].concat(), "more numbers than the layers need");
    refused(&[&bytes[..], &[0]].concat(), "more numbers than the layers need");
    refused(b"vb-nn: 1\nlayer: a 1 1", "no empty line");
    refused(b"vb-nn: 2\n\n", "format 2 is not supported (only 1 is)");
    refused(b"PK\x03\x04: x\n\n", "not a weights file");
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
    refused("other", 2, 1, "no network other");
    refused("net", 3, 1, "net turns 2 inputs into 1 outputs, and not 3 into 1");
    let mut other = weights();
    other.layers[1].shape = Shape::Dense { inputs: 1, outputs: 1 };
    assert!(other.network("net", 2, 1).unwrap_err().to_string().contains("do not match"));
}

/// A network with weights from a normal distribution as training begins with, and inputs of about 1.
fn random(sizes: &[usize], seed: u64) -> Network {
    let mut rng = crate::rng::Rng::new(seed);
    let layers = sizes.windows(2).map(|s| {
        let weights =
            (0..s[0] * s[1]).map(|_| (rng.normal() / (s[0] as f64).sqrt()) as f32).collect::<Vec<_>>();
        let bias = (0..s[1]).map(|_| 0.3 * rng.normal() as f32).collect::<Vec<_>>();
        layer("random", s[0], &weights, &bias)
    });
    Network::new(layers.collect()).unwrap()
}

#[test]
fn numbers_in_fixed_point_are_the_nearest_ones() {
    for (value, fixed) in [
        (0.0, 0),
        (1.0, 2048),
        (-1.0, -2048),
        (0.6 / 2048.0, 1),
        (0.4 / 2048.0, 0),
        (-0.6 / 2048.0, -1),
        (100.0, i16::MAX),
        (-100.0, i16::MIN),
        (f32::INFINITY, i16::MAX),
        (f32::NAN, i16::MIN),
    ] {
        assert_eq!(to_fixed(value), fixed, "{value}");
    }
    assert_eq!(from_fixed(to_fixed(-3.25)), -3.25);
}

#[test]
fn a_network_in_fixed_point_gives_nearly_the_same() {
    let mut rng = crate::rng::Rng::new(9);
    for (sizes, parts) in [
        (&[19, 32, 32, 6][..], &[11, 8][..]),
        (&[60, 64, 8], &[60]),
        (&[8, 1], &[8]),
        (&[3, 5, 7, 2], &[1, 2]),
    ] {
        let network = random(sizes, sizes.len() as u64);
        let fixed = network.fixed(parts).unwrap();
        assert_eq!(fixed.pairs(), parts.iter().map(|n| n.div_ceil(2)).sum::<usize>());
        let mut input = vec![[0.0; LANES]; network.inputs()];
        input.iter_mut().flatten().for_each(|v| *v = rng.normal() as f32);
        let (mut pairs, mut first) = (Vec::new(), 0);
        for part in parts {
            let mut own = vec![Pair::default(); part.div_ceil(2)];
            Pair::fill(&mut own, &input[first..first + part]);
            pairs.append(&mut own);
            first += part;
        }
        let (mut exact, mut output) =
            (vec![[0.0; LANES]; network.outputs()], vec![[0; LANES]; network.outputs()]);
        network.run(&input, &mut exact, &mut Scratch::default());
        fixed.run(&pairs, &mut output, &mut FixedScratch::default());
        for (exact, fixed) in exact.iter().flatten().zip(output.iter().flatten()) {
            // Each value is off by at most half a step of 1/2048, and about 60 of them with weights of 1/8 by two or
            // three.
            assert!(
                (exact - from_fixed(*fixed)).abs() < 3.0 / 2048.0,
                "{sizes:?}: {exact} {}",
                from_fixed(*fixed)
            );
        }
    }
}

#[test]
fn sums_in_fixed_point_hold_whatever_the_inputs_are() {
    // Weights and inputs at their maximum: the sum would be 120 times 15.99 times 16, and saturates.
    let network = Network::new(vec![layer("big", 120, &[15.99; 240], &[3.0, -3.0])]).unwrap();
    let fixed = network.fixed(&[120]).unwrap();
    for (value, end) in [(100.0, i16::MAX), (-100.0, i16::MIN)] {
        let mut pairs = [Pair::default(); 60];
        Pair::fill(&mut pairs, &[[value; LANES]; 120]);
        let mut output = [[0; LANES]; 2];
        fixed.run(&pairs, &mut output, &mut FixedScratch::default());
        assert_eq!(output, [[end; LANES]; 2]);
    }
    let large = Network::new(vec![layer("large", 4, &[20_000.0; 4], &[0.0])]).unwrap();
    assert!(large.fixed(&[4]).is_none());
}

#[test]
fn values_that_lie_together_become_pairs() {
    let rows: [Fixed; LANES] = std::array::from_fn(|l| std::array::from_fn(|c| (10 * l + c) as i16));
    let column = |c: usize| -> Fixed { std::array::from_fn(|l| rows[l][c]) };
    let pairs = [0, 2, 4, 6].map(|c| Pair::new(column(c), column(c + 1)));
    assert_eq!(Pair::across(&rows), pairs);
}

/// Two planes of 3 x 4 values, a kernel of 2 x 2 that moves by 2, and a row and column of zeros around them: planes of 2 x 3.
fn convolution() -> Layer {
    let shape = Convolution { planes: 2, rows: 3, cols: 4, outputs: 2, kernel: 2, stride: 2, padding: 1 };
    let weights = vec![1.0, 2.0, 3.0, 4.0, 10.0, 20.0, 30.0, 40.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    Layer { name: "planes.0".into(), shape: Shape::Convolution(shape), weights, bias: vec![0.5, -1.0] }
}

#[test]
fn a_convolution_is_its_sums_by_hand() {
    let layer = convolution();
    assert_eq!((layer.shape.inputs(), layer.shape.outputs(), layer.shape.multiplications()), (24, 12, 96));
    let network = Network::new(vec![layer]).unwrap();
    // The first plane counts from 1 row by row, the second is 1 in its first corner.
    let value = |k: usize| if k < 12 { k as f32 + 1.0 } else { f32::from(u8::from(k == 12)) };
    let input: Vec<Lanes> = (0..24).map(|k| [value(k); LANES]).collect();
    let mut output = [[0.0; LANES]; 12];
    network.run(&input, &mut output, &mut Scratch::default());
    // The kernel begins above and left of the input: its last weight meets 1, and in the second plane the corner.
    assert_eq!(output[0], [4.0 + 40.0 + 0.5; LANES]);
    // The second and third values of the first row: 3·2 + 4·3.
    assert_eq!(output[1], [18.5; LANES]);
    // The last column, and the zeros behind it: 3·4.
    assert_eq!(output[2], [12.5; LANES]);
    // The second and third values of the rows below: 1·6 + 2·7 + 3·10 + 4·11.
    assert_eq!(output[4], [94.5; LANES]);
    // The second plane of the output is the last of the four values, less 1.
    assert_eq!([output[6][0], output[7][0], output[8][0], output[10][0]], [0.0, 2.0, -1.0, 10.0]);
    assert!(network.fixed(&[24]).is_none());
}

#[test]
fn convolutions_are_written_and_read_like_dense_layers() {
    let layers = vec![convolution(), layer("planes.1", 12, &[0.25; 12], &[1.0])];
    let weights = Weights { notes: Vec::new(), layers };
    let again = Weights::parse(&weights.bytes()).unwrap();
    assert_eq!(again, weights);
    assert!(again.network("planes", 24, 1).is_ok());
    for (line, says) in [
        ("a 2 3 4 2 2 0 1", "convolution \"a 2 3 4 2 2 0 1\" is not"),
        ("a 2 3 4 2 6 1 1", "is not"),
        ("a 2 3 4", "is not"),
        ("a 2 3 4 2 2 1 5000", "none above 1024"),
        ("a 1024 1024 1024 1024 1024 1 0", "more than"),
    ] {
        let e =
            Weights::parse(format!("vb-nn: 1\nconvolution: {line}\n\n").as_bytes()).unwrap_err().to_string();
        assert!(e.contains(says), "{line}: {e}");
    }
}
