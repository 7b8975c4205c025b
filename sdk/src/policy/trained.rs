//! Policies whose networks were trained in an environment.

use super::{ActionKind, Actuator, Dtype, Layout, Observer, Part, Row, Sight};
use crate::nn::{LANES, Lanes, Network, Scratch, Weights};
use crate::{Command, Observation, PlannerError, Task, math};

/// The control rate for which policies are trained, Hz.
const CONTROL_HZ: &str = "10";
/// The slope of the activation after the convolution, which is that of [`Network`].
const LEAK: f32 = crate::nn::LEAK;

/// What a file of weights says of the policy that it is for, in its notes.
///
/// - `parts`: the names of the parts of an observation, with blanks between them;
/// - `sight`: cells, resolution, ahead, points and spacing of [`Sight`];
/// - `labels`: the labels of which planes are made, one for each label and each part of labels: 1 where the label is, else 0;
/// - `action`: `speed SLOWEST FASTEST`, `rate SLOWEST FASTEST` or `pedals` ([`ActionKind`]);
/// - `control_hz`: 10;
/// - `relief`, where there is one: by what the relief of each crop of heights is multiplied, which then is a plane of its own behind
///   it. The relief is what a height is above the mean of the 5 × 5 heights around it, where the outermost ones go on beyond the
///   edge: a ledge that stops a wheel stands out of it, which is little beside a hill;
/// - `squash`, where there is one: `tanh`, by which what the networks give becomes an action.
///
/// `python -m vertibench.training export` writes such files.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicySpec {
    /// The names of the parts of an observation.
    pub parts: Vec<String>,
    /// The sizes of crops and path for which the networks were trained.
    pub sight: Sight,
    /// The labels, each of which becomes a plane of 0 and 1.
    pub labels: Vec<u8>,
    /// What an action means.
    pub action: ActionKind,
    /// By what the relief of heights is multiplied; `None` if it is no plane.
    pub relief: Option<f32>,
    /// Whether the networks' outputs become actions by the hyperbolic tangent.
    pub is_squashed: bool,
}

impl PolicySpec {
    /// Reads what a file of weights says of its policy.
    ///
    /// # Errors
    /// Returns an error that names the note that is missing or wrong.
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
            return Err(wrong("control_hz", rate, "10, at which planners of policies are asked"));
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

/// A policy's networks: numbers of an observation in, an action out.
///
/// Crops are planes for a convolution, the network `eyes` of one layer; all other numbers go beside what it gives into the network
/// `head`. Numbers are divided by their usual sizes and limited, as in a flat observation. A part of labels makes a plane for each
/// label of [`PolicySpec::labels`]. Planes of numbers come first, in the order of the parts,
/// each of heights with that of its relief behind it, then those of labels.
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
    /// Of a part of [`Dtype::F32`].
    F32(&'a [f32]),
    /// Of a part of [`Dtype::U8`].
    U8(&'a [u8]),
}

impl PolicyNetwork {
    /// The networks of a file of weights, for observations of this layout.
    ///
    /// # Errors
    /// Returns an error if the file has no such networks, or they don't fit the layout.
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
            return Err(
                format!("weights: parts: {}: labels that are no crop can't be seen", part.name).into()
            );
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

    /// The action for an observation, whose parts come in the order of the layout. Missing numbers count as 0.
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

/// A number as a network sees it.
fn limited(value: f32) -> f32 {
    value.clamp(-Layout::FLAT_BOUND, Layout::FLAT_BOUND)
}

/// Whether a part has a relief.
fn has_relief(part: &Part) -> bool {
    part.is_crop() && part.name.contains("height")
}

/// What each of the heights on a square is above the mean of those around it, up to two rows and columns away.
fn relief(heights: &[f32], cells: usize) -> impl Iterator<Item = f32> {
    const AROUND: [usize; 5] = [0, 1, 2, 3, 4];
    // The outermost ones go on beyond the edge.
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

/// A policy that was trained, as it drives: what it sees, its networks, and what it does.
#[derive(Clone, Debug)]
pub struct Trained {
    layout: Layout,
    observer: Observer,
    actuator: Actuator,
    network: PolicyNetwork,
    /// Room for the numbers of each part.
    numbers: Vec<Vec<f32>>,
    labels: Vec<Vec<u8>>,
}

impl Trained {
    /// The policy of a file of weights, for a task.
    ///
    /// # Errors
    /// Returns an error if the file isn't one of a policy, or sees what the task's perception doesn't give.
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
    /// Returns an error if the action isn't finite, as after an observation that makes no sense.
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
            return Err("the policy's action is not finite: the observation makes no sense".into());
        }
        Ok(self.actuator.command(&action, observation))
    }
}
