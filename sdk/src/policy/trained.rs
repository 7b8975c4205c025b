//! Policies with networks that were trained in an environment.

use super::{ActionKind, Actuator, Dtype, Layout, Observer, Part, Row, Sight};
use crate::nn::{LANES, Lanes, Network, Scratch, Weights};
use crate::{Command, Observation, PlannerError, Task, math};

/// The control rate of trained policies, Hz.
const CONTROL_HZ: &str = "10";
/// The negative slope of the activation after the convolution, as in [`Network`].
const LEAK: f32 = crate::nn::LEAK;

/// The specification of a policy in the notes of its weights file.
///
/// - `parts`: the names of the parts of an observation, with blanks between them;
/// - `sight`: the observation window: cells, resolution, ahead, points and spacing of [`Sight`];
/// - `labels`: the labels with one-hot planes, for each part of labels: 1 at cells with the label, otherwise 0;
/// - `action`: `speed SLOWEST FASTEST`, `rate SLOWEST FASTEST` or `pedals` ([`ActionKind`]);
/// - `control_hz`: 10;
/// - `relief` (optional): the factor of the relief of each crop of heights, which then is an additional plane after it.
///   The relief is the height above the mean of the 5 × 5 heights around it, with the edge replicated: it emphasises
///   steps, which are small compared with hills;
/// - `squash` (optional): `tanh`, which maps the network outputs to actions.
///
/// `python -m vertibench.training export` writes such files.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicySpec {
    /// The names of the parts of an observation.
    pub parts: Vec<String>,
    /// The observation window of the training.
    pub sight: Sight,
    /// The labels with one-hot planes.
    pub labels: Vec<u8>,
    /// The meaning of an action.
    pub action: ActionKind,
    /// The factor of the relief; `None` without relief planes.
    pub relief: Option<f32>,
    /// Whether the network outputs are mapped to actions with the hyperbolic tangent.
    pub is_squashed: bool,
}

impl PolicySpec {
    /// Parses the specification from a weights file.
    ///
    /// # Errors
    /// Returns an error that names the missing or invalid note.
    pub fn of(weights: &Weights) -> Result<Self, PlannerError> {
        let note = |key: &str| {
            weights
                .note(key)
                .ok_or_else(|| PlannerError::from(format!("weights: {key}: the note is missing")))
        };
        let wrong = |key: &str, value: &str, want: &str| {
            PlannerError::from(format!("weights: {key}: \"{value}\" is not {want}"))
        };
        let sight = note("sight")?;
        let sizes: Option<Vec<f64>> = sight.split(' ').map(|n| n.parse().ok()).collect();
        let Some([cells, resolution, ahead, points, spacing]) = sizes.as_deref() else {
            return Err(wrong("sight", sight, "cells, resolution, ahead, points and spacing"));
        };
        let labels = note("labels")?;
        let wanted = labels.split_whitespace().map(|n| n.parse().ok()).collect();
        let Some(wanted): Option<Vec<u8>> = wanted else {
            return Err(wrong("labels", labels, "a list of labels from 0 to 255"));
        };
        let action = note("action")?;
        let kind = match action.split(' ').collect::<Vec<_>>()[..] {
            ["pedals"] => Some(ActionKind::Pedals),
            [name @ ("speed" | "rate"), slowest, fastest] => match (slowest.parse(), fastest.parse()) {
                (Ok(slowest), Ok(fastest)) if slowest < fastest => Some(match name {
                    "rate" => ActionKind::Rate { slowest, fastest },
                    _ => ActionKind::Speed { slowest, fastest },
                }),
                _ => None,
            },
            _ => None,
        };
        let kind = kind.ok_or_else(|| {
            wrong("action", action, "\"speed SLOWEST FASTEST\", \"rate SLOWEST FASTEST\" or \"pedals\"")
        })?;
        let rate = note("control_hz")?;
        if rate != CONTROL_HZ {
            return Err(wrong("control_hz", rate, "10, the control rate of policies"));
        }
        let gain = |text: &str| text.parse().ok().filter(|g: &f32| g.is_finite());
        let relief = match weights.note("relief") {
            None => None,
            Some(text) => Some(gain(text).ok_or_else(|| wrong("relief", text, "a number"))?),
        };
        let is_squashed = match weights.note("squash") {
            None => false,
            Some("tanh") => true,
            Some(other) => return Err(wrong("squash", other, "tanh")),
        };
        Ok(Self {
            relief,
            is_squashed,
            parts: note("parts")?.split_whitespace().map(str::to_owned).collect(),
            sight: Sight {
                cells: *cells as usize,
                resolution: *resolution,
                ahead: *ahead,
                points: *points as usize,
                spacing: *spacing,
            },
            labels: wanted,
            action: kind,
        })
    }
}

/// A policy's networks: observation in, action out.
///
/// Crops are planes for a convolution, the network `eyes` of one layer; its output and all other numbers are the input
/// of the network `head`. Numbers are divided by their normalisation scales and clamped, as in a flat observation. A
/// part of labels has a one-hot plane for each label of [`PolicySpec::labels`]. Planes of numbers come first, in the
/// order of the parts, each plane of heights followed by its relief, then planes of labels.
#[derive(Clone, Debug)]
pub struct PolicyNetwork {
    parts: Vec<Part>,
    labels: Vec<u8>,
    relief: Option<f32>,
    is_squashed: bool,
    /// Rows and columns of a crop.
    cells: usize,
    eyes: Option<Network>,
    head: Network,
    planes: Vec<Lanes>,
    inputs: Vec<Lanes>,
    outputs: Vec<Lanes>,
    scratch: Scratch,
}

/// The numbers of a part of an observation.
#[derive(Clone, Copy, Debug)]
pub enum Numbers<'a> {
    /// For a part of [`Dtype::F32`].
    F32(&'a [f32]),
    /// For a part of [`Dtype::U8`].
    U8(&'a [u8]),
}

impl PolicyNetwork {
    /// The networks of a weights file, for observations of this layout.
    ///
    /// # Errors
    /// Returns an error if the networks do not exist or do not match the layout.
    pub fn new(weights: &Weights, spec: &PolicySpec, layout: &Layout) -> Result<Self, PlannerError> {
        let parts = layout.parts().to_vec();
        let cells = layout.sight().cells.pow(2);
        let planes_of = |p: &Part| match p.dtype {
            Dtype::F32 => 1 + usize::from(spec.relief.is_some() && has_relief(p)),
            Dtype::U8 => spec.labels.len(),
        };
        let planes: usize = parts.iter().filter(|p| p.is_crop()).map(planes_of).sum();
        let others: usize = parts.iter().filter(|p| !p.is_crop()).map(Part::width).sum();
        if let Some(part) = parts.iter().find(|p| p.dtype == Dtype::U8 && !p.is_crop()) {
            return Err(format!("weights: parts: {}: only crops of labels are supported", part.name).into());
        }
        let eyes = match planes {
            0 => None,
            _ => {
                let outputs =
                    weights.layers.iter().find(|l| l.name == "eyes.0").map_or(0, |l| l.shape.outputs());
                Some(weights.network("eyes", planes * cells, outputs)?)
            }
        };
        let seen = eyes.as_ref().map_or(0, Network::outputs);
        let head = weights.network("head", seen + others, spec.action.dimensions().len())?;
        Ok(Self {
            labels: spec.labels.clone(),
            relief: spec.relief,
            is_squashed: spec.is_squashed,
            cells: layout.sight().cells,
            planes: vec![[0.0; LANES]; planes * cells],
            inputs: vec![[0.0; LANES]; seen + others],
            outputs: vec![[0.0; LANES]; head.outputs()],
            parts,
            eyes,
            head,
            scratch: Scratch::default(),
        })
    }

    /// The action for an observation, with parts in the order of the layout. Missing numbers are 0.
    pub fn act(&mut self, parts: &[Numbers<'_>]) -> Vec<f64> {
        let seen = self.eyes.as_ref().map_or(0, Network::outputs);
        let mut planes = self.planes.iter_mut();
        let mut inputs = self.inputs[seen..].iter_mut();
        for (part, numbers) in self.parts.iter().zip(parts) {
            let Numbers::F32(numbers) = numbers else { continue };
            let usual = |k: usize| part.entry(k).usual as f32;
            for (k, value) in numbers.iter().take(part.width()).enumerate() {
                let to = if part.is_crop() { planes.next() } else { inputs.next() };
                if let Some(to) = to {
                    to[0] = limited(value / usual(k));
                }
            }
            if let Some(gain) = self.relief.filter(|_| has_relief(part) && numbers.len() == self.cells.pow(2))
            {
                for ((k, rise), to) in relief(numbers, self.cells).enumerate().zip(&mut planes) {
                    to[0] = limited(gain * (rise / usual(k)));
                }
            }
        }
        for numbers in parts {
            let Numbers::U8(numbers) = numbers else { continue };
            for label in &self.labels {
                for (value, to) in numbers.iter().zip(&mut planes) {
                    to[0] = f32::from(u8::from(value == label));
                }
            }
        }
        if let Some(eyes) = &self.eyes {
            eyes.run(&self.planes, &mut self.inputs[..seen], &mut self.scratch);
            for value in &mut self.inputs[..seen] {
                let leak = LEAK * value[0];
                value[0] = if value[0] < leak { leak } else { value[0] };
            }
        }
        self.head.run(&self.inputs, &mut self.outputs, &mut self.scratch);
        let squash = |value: f64| if self.is_squashed { math::tanh(value) } else { value };
        self.outputs.iter().map(|o| squash(f64::from(o[0]))).collect()
    }
}

/// Normalises a number for a network.
fn limited(value: f32) -> f32 {
    value.clamp(-Layout::FLAT_BOUND, Layout::FLAT_BOUND)
}

/// Whether a part has a relief.
fn has_relief(part: &Part) -> bool {
    part.is_crop() && part.name.contains("height")
}

/// The relief of a square of heights: each height above the mean of those up to two rows and columns away.
fn relief(heights: &[f32], cells: usize) -> impl Iterator<Item = f32> {
    const AROUND: [usize; 5] = [0, 1, 2, 3, 4];
    // The edge is replicated.
    let at = move |row: usize, col: usize| {
        let inside = |i: usize| i.saturating_sub(2).min(cells - 1);
        heights[inside(row) * cells + inside(col)]
    };
    (0..cells * cells).map(move |k| {
        let (row, col) = (k / cells, k % cells);
        let sum: f32 = AROUND.iter().flat_map(|r| AROUND.map(|c| at(row + r, col + c))).sum();
        heights[k] - sum / 25.0
    })
}

/// A trained policy: observer, networks and actuator.
#[derive(Clone, Debug)]
pub struct Trained {
    layout: Layout,
    observer: Observer,
    actuator: Actuator,
    network: PolicyNetwork,
    /// Buffers for the numbers of each part.
    numbers: Vec<Vec<f32>>,
    labels: Vec<Vec<u8>>,
}

impl Trained {
    /// Creates the policy of a weights file, for a task.
    ///
    /// # Errors
    /// Returns an error if the file contains no policy, or the policy needs data omitted by the task's perception
    /// profile.
    pub fn new(weights: &Weights, task: &Task) -> Result<Self, PlannerError> {
        let spec = PolicySpec::of(weights)?;
        let layout = Layout::new(&spec.parts, spec.sight, task)?;
        let room = |dtype: Dtype| move |p: &Part| if p.dtype == dtype { p.width() } else { 0 };
        Ok(Self {
            observer: Observer::new(task, &layout)?,
            actuator: Actuator::new(spec.action, task),
            network: PolicyNetwork::new(weights, &spec, &layout)?,
            numbers: layout.parts().iter().map(room(Dtype::F32)).map(|n| vec![0.0; n]).collect(),
            labels: layout.parts().iter().map(room(Dtype::U8)).map(|n| vec![0; n]).collect(),
            layout,
        })
    }

    /// The command for an observation of the task.
    ///
    /// # Errors
    /// Returns an error if the action is not finite, e.g. after an invalid observation.
    pub fn step(&mut self, task: &Task, observation: &Observation) -> Result<Command, PlannerError> {
        self.observer.look(observation);
        let mut parts = Vec::with_capacity(self.numbers.len());
        let rows = self.numbers.iter_mut().zip(&mut self.labels);
        for (part, (numbers, labels)) in self.layout.parts().iter().zip(rows) {
            parts.push(match part.dtype {
                Dtype::F32 => {
                    self.observer.fill(task, part, Row::F32(numbers));
                    Numbers::F32(numbers)
                }
                Dtype::U8 => {
                    self.observer.fill(task, part, Row::U8(labels));
                    Numbers::U8(labels)
                }
            });
        }
        let action = self.network.act(&parts);
        if action.iter().any(|a| !a.is_finite()) {
            return Err("the policy's action is not finite, because the observation is invalid".into());
        }
        Ok(self.actuator.command(&action, observation))
    }
}
