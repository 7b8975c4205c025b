//! Adam (Kingma and Ba 2015), with its state at hand for checkpoints.

use candle_core::backprop::GradStore;
use candle_core::{Result, Tensor, Var};

const BETA: [f64; 2] = [0.9, 0.99];
const EPSILON: f64 = 1e-8;

/// The optimiser of named variables.
pub(crate) struct Adam {
    variables: Vec<(String, Var)>,
    /// Running means of each gradient and of its square.
    moments: Vec<[Tensor; 2]>,
}

impl Adam {
    pub(crate) fn new(variables: Vec<(String, Var)>) -> Result<Self> {
        let zero = |v: &Var| -> Result<[Tensor; 2]> { Ok([v.zeros_like()?, v.zeros_like()?]) };
        let moments = variables.iter().map(|(_, v)| zero(v)).collect::<Result<_>>()?;
        Ok(Self { variables, moments })
    }

    /// One step, number `step` from 1.
    pub(crate) fn step(&mut self, gradients: &GradStore, step: u64, rate: f64) -> Result<()> {
        let correction = BETA.map(|b| 1.0 - vb_math::pow(b, step as f64));
        for ((_, variable), moments) in self.variables.iter().zip(&mut self.moments) {
            let Some(g) = gradients.get(variable) else { continue };
            // Without the graph that the gradient came from.
            let g = g.detach();
            let first = ((&moments[0] * BETA[0])? + (&g * (1.0 - BETA[0]))?)?;
            let second = ((&moments[1] * BETA[1])? + (g.sqr()? * (1.0 - BETA[1]))?)?;
            let scale = ((&second / correction[1])?.sqrt()? + EPSILON)?;
            let change = ((&first / correction[0])? / scale)?;
            variable.set(&(variable.as_tensor() - (change * rate)?)?.detach())?;
            *moments = [first.detach(), second.detach()];
        }
        Ok(())
    }

    /// Variables and moments by name.
    pub(crate) fn state(&self) -> Vec<(String, Tensor)> {
        let mut all = Vec::new();
        for ((name, variable), [first, second]) in self.variables.iter().zip(&self.moments) {
            all.push((name.clone(), variable.as_tensor().clone()));
            all.push((format!("adam.first.{name}"), first.clone()));
            all.push((format!("adam.second.{name}"), second.clone()));
        }
        all
    }

    /// Takes over a state; names that it lacks, and tensors of another shape, are an error.
    pub(crate) fn restore(&mut self, mut tensor: impl FnMut(&str) -> Result<Tensor>) -> Result<()> {
        for ((name, variable), moments) in self.variables.iter().zip(&mut self.moments) {
            variable.set(&tensor(name)?)?;
            *moments = [tensor(&format!("adam.first.{name}"))?, tensor(&format!("adam.second.{name}"))?];
        }
        Ok(())
    }
}
