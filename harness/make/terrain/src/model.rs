//! The model on disk: safetensors with the decoder's weights, the curves of the passes and, as metadata, what else one needs to
//! make a surface.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::bands::{Curve, MAX_PASSES, Pass};
use crate::decoder::Decoder;
use crate::shape::DECODER;

/// Largest file that is taken for a model, bytes.
const MAX_BYTES: u64 = 64 << 20;
pub const SCHEMA: u32 = 2;
const KEY: &str = "vb-terrain";

/// What of a model's card its reader needs.
#[derive(Deserialize)]
struct Checksum {
    sha256: String,
}

#[derive(Debug, Error)]
pub enum ModelError {
    #[error("{}: can't be read: {source}", path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },
    #[error("{}: {problem}: restore the file, or retrain the model", path.display())]
    NoModel { path: PathBuf, problem: String },
}

/// What a model says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// Version of this format: [`SCHEMA`].
    pub schema: u32,
    /// Distance between the decoder's samples, m. Model files call it `pitch` until their schema changes, so that training makes
    /// the shipped one again byte for byte.
    #[serde(rename = "pitch")]
    pub resolution: f64,
    /// Standard deviation of height at full relief (level `high`), m.
    pub relief: f64,
    /// Share of the noise that details are drawn from: 1 as in training, 0 none.
    pub detail: f64,
    /// Standard deviations of the swells, waves longer than the decoder makes, in its units: the shorter and the longer of
    /// [`SWELLS`](crate::shape::SWELLS).
    pub swell: [f64; 2],
    /// Passes over what decoder and swells make.
    pub passes: usize,
    /// Mean of a surface before it is scaled.
    pub mean: f64,
    /// Standard deviation of a surface before it is scaled.
    pub std: f64,
}

/// A trained model: draws surfaces.
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) header: Header,
    pub(crate) decoder: Decoder,
    pub(crate) passes: Vec<Pass>,
}

/// Weight and bias of each layer of the decoder.
pub type Weights = Vec<(Vec<f32>, Vec<f32>)>;

impl Model {
    /// A model of these weights: for each layer of [`DECODER`] the kernel, (row, column, from, to) in this order, and the
    /// bias; and of these passes over what the decoder makes.
    ///
    /// # Errors
    /// What is wrong with the header or a layer's size, in words.
    pub fn new(header: Header, weights: &Weights, passes: &[Pass]) -> Result<Self, String> {
        if header.schema != SCHEMA {
            return Err(format!("schema {}: must be {SCHEMA}", header.schema));
        }
        for (name, value) in
            [("resolution", header.resolution), ("relief", header.relief), ("std", header.std)]
        {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{name} is {value}: must be above 0"));
            }
        }
        if !header.mean.is_finite() {
            return Err(format!("mean is {}: must be a number", header.mean));
        }
        if !(0.0..=1.0).contains(&header.detail) {
            return Err(format!("detail is {}: must be from 0 to 1", header.detail));
        }
        if header.swell.iter().any(|s| !(s.is_finite() && *s >= 0.0)) {
            return Err(format!("swell is {:?}: must be two numbers from 0", header.swell));
        }
        if header.passes > MAX_PASSES || header.passes != passes.len() {
            return Err(format!(
                "passes is {}: must be their number, {}, and at most {MAX_PASSES}",
                header.passes,
                passes.len()
            ));
        }
        if weights.len() != DECODER.len() {
            return Err(format!("{} layers: must be {}", weights.len(), DECODER.len()));
        }
        for (i, ((weight, bias), layer)) in weights.iter().zip(DECODER).enumerate() {
            let wanted = layer.kernel * layer.kernel * layer.from * layer.to;
            if (weight.len(), bias.len()) != (wanted, layer.to) {
                return Err(format!(
                    "layer {i} has {} weights and {} biases: must be {wanted} and {}",
                    weight.len(),
                    bias.len(),
                    layer.to
                ));
            }
            if weight.iter().chain(bias).any(|v| !v.is_finite()) {
                return Err(format!("layer {i} has weights that are not numbers"));
            }
        }
        Ok(Self { header, decoder: Decoder::new(weights), passes: passes.to_vec() })
    }

    /// Reads a model file, and holds it against the SHA-256 in its card: the file of the same name that ends in `.json`.
    ///
    /// # Errors
    /// [`ModelError`] if it can't be read, is no model, or isn't that of its card.
    pub fn read(path: &Path) -> Result<Self, ModelError> {
        let unreadable = |source| ModelError::Unreadable { path: path.to_owned(), source };
        let problem = |problem| ModelError::NoModel { path: path.to_owned(), problem };
        let bytes = vb_files::read(path, MAX_BYTES).map_err(unreadable)?;
        let model = Self::decode(&bytes).map_err(problem)?;
        // Most damages leave it a model, which draws other ground.
        let card = path.with_extension("json");
        let text = vb_files::read_text(&card, vb_files::DOCUMENT).map_err(|e| {
            problem(format!("its card {}, which has its SHA-256, can't be read: {e}", card.display()))
        })?;
        let stated: Checksum = serde_json::from_str(&text)
            .map_err(|e| problem(format!("its card {} has no SHA-256: {e}", card.display())))?;
        let own = vb_files::sha256(&bytes);
        if own != stated.sha256 {
            return Err(problem(format!(
                "its SHA-256 is {own}, its card {} says {}",
                card.display(),
                stated.sha256
            )));
        }
        Ok(model)
    }

    /// Reads a model from a file's bytes.
    ///
    /// # Errors
    /// What is wrong with them, in words.
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
        let damaged = |e: &dyn std::fmt::Display| format!("is not a complete safetensors file ({e})");
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| damaged(&e))?;
        let text = metadata.metadata().as_ref().and_then(|m| m.get(KEY));
        let text = text.ok_or_else(|| format!("has no {KEY} metadata"))?;
        let header: Header = serde_json::from_str(text).map_err(|e| format!("metadata: {e}"))?;
        let tensors = SafeTensors::deserialize(bytes).map_err(|e| damaged(&e))?;
        let numbers = |name: String| -> Result<Vec<f32>, String> {
            let t = tensors.tensor(&name).map_err(|_| format!("has no tensor {name}"))?;
            if t.dtype() != Dtype::F32 {
                return Err(format!("tensor {name} is {:?}: must be F32", t.dtype()));
            }
            Ok(t.data().chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
        };
        let weights = (0..DECODER.len())
            .map(|i| Ok((numbers(format!("decoder.{i}.weight"))?, numbers(format!("decoder.{i}.bias"))?)))
            .collect::<Result<Weights, String>>()?;
        let curve = |name: String| {
            let mut from = numbers(name.clone())?;
            let to = from.split_off(from.len() / 2);
            Curve::new(from, to).map_err(|e| format!("tensor {name}: {e}"))
        };
        let passes = (0..header.passes.min(MAX_PASSES))
            .map(|pass| {
                let octave = |band: usize| curve(format!("pass.{pass}.octave.{band}"));
                let octaves = [octave(0)?, octave(1)?, octave(2)?];
                Ok(Pass { octaves, steepness: curve(format!("pass.{pass}.steepness"))? })
            })
            .collect::<Result<Vec<_>, String>>()?;
        Self::new(header, &weights, &passes)
    }

    /// The bytes of a model file. The same header, weights and passes give the same bytes.
    ///
    /// # Errors
    /// What is wrong with header, weights or passes, in words.
    pub fn encode(header: Header, weights: &Weights, passes: &[Pass]) -> Result<Vec<u8>, String> {
        Self::new(header, weights, passes)?;
        let mut tensors = BTreeMap::new();
        let bytes = |v: &[f32]| v.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        for (i, ((weight, bias), layer)) in weights.iter().zip(DECODER).enumerate() {
            let shape = vec![layer.kernel, layer.kernel, layer.from, layer.to];
            tensors.insert(format!("decoder.{i}.weight"), (shape, bytes(weight)));
            tensors.insert(format!("decoder.{i}.bias"), (vec![layer.to], bytes(bias)));
        }
        for (i, pass) in passes.iter().enumerate() {
            let octaves = pass.octaves.iter().enumerate().map(|(k, c)| (format!("octave.{k}"), c));
            for (name, curve) in octaves.chain([("steepness".to_owned(), &pass.steepness)]) {
                let (from, to) = curve.knots();
                let values = [bytes(from), bytes(to)].concat();
                tensors.insert(format!("pass.{i}.{name}"), (vec![2, from.len()], values));
            }
        }
        let views = tensors
            .iter()
            .map(|(name, (shape, data))| {
                Ok((
                    name.as_str(),
                    TensorView::new(Dtype::F32, shape.clone(), data).map_err(|e| e.to_string())?,
                ))
            })
            .collect::<Result<Vec<_>, String>>()?;
        let header = serde_json::to_string(&header).map_err(|e| e.to_string())?;
        // One entry: its order can't vary.
        let metadata = [(KEY.to_owned(), header)].into_iter().collect();
        safetensors::serialize(views, Some(metadata)).map_err(|e| e.to_string())
    }

    /// What the decoder makes of the numbers of (n + 4)² cells, [`NUMBERS`](crate::shape::NUMBERS) each, row by row: the n × n in the middle, as
    /// (8 n)² samples, row by row.
    ///
    /// # Panics
    /// If there are too few numbers.
    #[must_use]
    pub fn block(&self, cells: &[f32], n: usize) -> Vec<f32> {
        self.decoder.run(cells, n)
    }

    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }
}
