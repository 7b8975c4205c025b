//! The weights file.
//!
//! It begins with text lines `key: value`, the first of which is `vb-nn: 1`. A line `layer: NAME INPUTS OUTPUTS`
//! declares a dense layer, and `convolution: NAME PLANES ROWS COLUMNS OUTPUTS KERNEL STRIDE PADDING` a [`Convolution`].
//! After an empty line follow the layers' numbers in this order as little-endian 32-bit floats: for each layer the
//! weights, in the order of [`Layer::weights`], then the bias. All other lines are notes of the training program.

use super::{Convolution, FixedNetwork, Layer, Network, Shape};

/// The version of the format.
const VERSION: &str = "1";
/// The maximum number of numbers in a file.
const NUMBERS: usize = 1 << 22;
/// The maximum of each size of a convolution.
const SIDE: usize = 1024;

/// Networks with notes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weights {
    /// The notes of the file, in its order.
    pub notes: Vec<(String, String)>,
    /// The layers, in the order of the file.
    pub layers: Vec<Layer>,
}

/// The reason why weights are invalid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WeightsError(String);

impl std::fmt::Display for WeightsError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "weights: {}", self.0)
    }
}

impl std::error::Error for WeightsError {}

impl From<WeightsError> for crate::PlannerError {
    fn from(e: WeightsError) -> Self {
        Self::new(e.to_string())
    }
}

fn wrong<T>(text: impl Into<String>) -> Result<T, WeightsError> {
    Err(WeightsError(text.into()))
}

impl Weights {
    /// Parses a file.
    ///
    /// # Errors
    /// Returns an error for another version, a truncated file, or a number that is not finite.
    pub fn parse(bytes: &[u8]) -> Result<Self, WeightsError> {
        let Some(end) = bytes.windows(2).position(|w| w == b"\n\n") else {
            return wrong("no empty line ends the header");
        };
        let Ok(head) = std::str::from_utf8(&bytes[..end]) else {
            return wrong("the header is not UTF-8 text");
        };
        let mut numbers =
            bytes[end + 2..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let mut own = Self::default();
        for (n, line) in head.lines().enumerate() {
            let Some((key, value)) = line.split_once(": ") else {
                return wrong(format!("line {}: \"{line}\" is not \"key: value\"", n + 1));
            };
            match (n, key) {
                (0, "vb-nn") if value == VERSION => {}
                (0, "vb-nn") => return wrong(format!("format {value} is not supported (only {VERSION} is)")),
                (0, _) => return wrong("not a weights file: the first line is not \"vb-nn: 1\""),
                (_, "layer" | "convolution") => {
                    let layer = own.layer(key, value, &mut numbers)?;
                    own.layers.push(layer);
                }
                _ => own.notes.push((key.to_owned(), value.to_owned())),
            }
        }
        if !bytes[end + 2..].len().is_multiple_of(4) || numbers.next().is_some() {
            return wrong("the file contains more numbers than the layers need");
        }
        Ok(own)
    }

    /// A layer declared in the header.
    fn layer(
        &self,
        kind: &str,
        value: &str,
        numbers: &mut impl Iterator<Item = f32>,
    ) -> Result<Layer, WeightsError> {
        let words: Vec<&str> = value.split(' ').collect();
        let sizes: Vec<usize> =
            words.iter().skip(1).filter_map(|w| w.parse().ok()).filter(|n| *n < NUMBERS).collect();
        let shape = match (kind, &sizes[..]) {
            _ if sizes.len() + 1 != words.len() => None,
            ("layer", [inputs, outputs]) => Some(Shape::Dense { inputs: *inputs, outputs: *outputs }),
            ("convolution", [planes, rows, cols, outputs, kernel, stride, padding]) if *stride > 0 => {
                let small = [rows, cols, kernel, stride, padding].iter().all(|n| **n <= SIDE);
                let (planes, rows, cols, outputs) = (*planes, *rows, *cols, *outputs);
                let (kernel, stride, padding) = (*kernel, *stride, *padding);
                let own = Convolution { planes, rows, cols, outputs, kernel, stride, padding };
                (small && planes.max(outputs) <= SIDE).then_some(Shape::Convolution(own))
            }
            _ => None,
        };
        let Some(shape) = shape.filter(|s| s.inputs() > 0 && s.outputs() > 0 && s.numbers().0 > 0) else {
            let want = match kind {
                "layer" => "NAME INPUTS OUTPUTS",
                _ => "NAME PLANES ROWS COLUMNS OUTPUTS KERNEL STRIDE PADDING, none above 1024",
            };
            return wrong(format!("{kind} \"{value}\" is not \"{want}\""));
        };
        let before: usize = self.layers.iter().map(|l| l.weights.len() + l.bias.len()).sum();
        let (weights, bias) = shape.numbers();
        let count = weights.saturating_add(bias);
        if before.saturating_add(count) > NUMBERS || shape.outputs() > NUMBERS {
            return wrong(format!("more than {NUMBERS} numbers"));
        }
        let name = words[0].to_owned();
        let all: Vec<f32> = numbers.take(count).collect();
        if all.len() < count {
            return wrong(format!("layer {name} is truncated"));
        }
        if let Some(k) = all.iter().position(|v| !v.is_finite()) {
            return wrong(format!("layer {name}: number {k} is {}", all[k]));
        }
        let (weights, bias) = all.split_at(weights);
        Ok(Layer { name, shape, weights: weights.to_vec(), bias: bias.to_vec() })
    }

    /// Serialises the file.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let mut head = format!("vb-nn: {VERSION}\n");
        for (key, value) in &self.notes {
            head += &format!("{key}: {value}\n");
        }
        for l in &self.layers {
            head += &match l.shape {
                Shape::Dense { inputs, outputs } => format!("layer: {} {inputs} {outputs}\n", l.name),
                Shape::Convolution(c) => format!(
                    "convolution: {} {} {} {} {} {} {} {}\n",
                    l.name, c.planes, c.rows, c.cols, c.outputs, c.kernel, c.stride, c.padding
                ),
            };
        }
        let numbers = self.layers.iter().flat_map(|l| l.weights.iter().chain(&l.bias));
        head.into_bytes().into_iter().chain(*b"\n").chain(numbers.flat_map(|v| v.to_le_bytes())).collect()
    }

    /// The value of a note.
    #[must_use]
    pub fn note(&self, key: &str) -> Option<&str> {
        self.notes.iter().find(|(k, _)| k == key).map(|(_, value)| value.as_str())
    }

    /// The network with the layers `NAME.0`, `NAME.1` and so on, and this number of inputs and outputs.
    ///
    /// # Errors
    /// Returns an error if it does not exist, its layers do not match, or it has other inputs or outputs.
    pub fn network(&self, name: &str, inputs: usize, outputs: usize) -> Result<Network, WeightsError> {
        let named = |k: usize| self.layers.iter().find(|l| l.name == format!("{name}.{k}")).cloned();
        let layers: Vec<Layer> = (0..).map_while(named).collect();
        if layers.is_empty() {
            return wrong(format!("no network {name}"));
        }
        let Some(network) = Network::new(layers) else {
            return wrong(format!("the layers of {name} do not match"));
        };
        if (network.inputs(), network.outputs()) != (inputs, outputs) {
            return wrong(format!(
                "{name} turns {} inputs into {} outputs, and not {inputs} into {outputs}: it was trained for another version of the \
                 planner",
                network.inputs(),
                network.outputs()
            ));
        }
        Ok(network)
    }

    /// The network in fixed point, with inputs in parts ([`Network::fixed`]).
    ///
    /// # Errors
    /// Returns an error if it does not exist, does not match, or its weights are too large.
    pub fn fixed_network(
        &self,
        name: &str,
        parts: &[usize],
        outputs: usize,
    ) -> Result<FixedNetwork, WeightsError> {
        let network = self.network(name, parts.iter().sum(), outputs)?;
        network
            .fixed(parts)
            .ok_or_else(|| WeightsError(format!("weights of {name} are too large for fixed point")))
    }
}
