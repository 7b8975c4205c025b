//! The arrays that environments write to.

use vb_sdk::policy::{Dtype, Row};

use crate::rows::Rows;
use crate::{Arena, Autoreset, Env, Step, TERMS};

/// The numbers of all environments, a row for each. What an environment has written is there once it was received, and stays
/// until it is sent on.
pub struct Output {
    /// For each part of the observation, or for the flat one.
    observations: Vec<Numbers>,
    /// The last observations of episodes, with [`Autoreset::SameStep`]; else none.
    finals: Vec<Numbers>,
    rewards: Rows<f64>,
    terms: Rows<f64>,
    terminated: Rows<bool>,
    truncated: Rows<bool>,
    /// Whether observations are flat.
    flat: bool,
}

enum Numbers {
    F32(Rows<f32>),
    U8(Rows<u8>),
}

/// Where an array lies: for each environment a row of `width` numbers.
#[derive(Clone, Copy, Debug)]
pub enum Pointer {
    /// Numbers of 32 bits.
    F32(*mut f32, usize),
    /// Labels.
    U8(*mut u8, usize),
    /// Numbers of 64 bits.
    F64(*mut f64, usize),
    /// Flags.
    Bool(*mut bool, usize),
}

impl Numbers {
    fn pointer(&self) -> Pointer {
        match self {
            Self::F32(rows) => Pointer::F32(rows.pointer(), rows.width()),
            Self::U8(rows) => Pointer::U8(rows.pointer(), rows.width()),
        }
    }
}

impl Output {
    /// The bytes of all observations of so many environments.
    pub(crate) fn bytes(arena: &Arena, count: usize, flat: bool, autoreset: Autoreset) -> usize {
        let size = |p: &vb_sdk::policy::Part| match p.dtype {
            Dtype::F32 => p.width().saturating_mul(4),
            Dtype::U8 => p.width(),
        };
        let one = if flat {
            arena.layout().flat_width().saturating_mul(4)
        } else {
            arena.layout().parts().iter().map(size).fold(0, usize::saturating_add)
        };
        let copies = if autoreset == Autoreset::SameStep { 2 } else { 1 };
        one.saturating_mul(count).saturating_mul(copies)
    }

    pub(crate) fn new(arena: &Arena, count: usize, flat: bool, autoreset: Autoreset) -> Self {
        let numbers = || -> Vec<Numbers> {
            if flat {
                return vec![Numbers::F32(Rows::new(count, arena.layout().flat_width()))];
            }
            let of = |p: &vb_sdk::policy::Part| match p.dtype {
                Dtype::F32 => Numbers::F32(Rows::new(count, p.width())),
                Dtype::U8 => Numbers::U8(Rows::new(count, p.width())),
            };
            arena.layout().parts().iter().map(of).collect()
        };
        Self {
            observations: numbers(),
            finals: if autoreset == Autoreset::SameStep { numbers() } else { Vec::new() },
            rewards: Rows::new(count, 1),
            terms: Rows::new(count, TERMS.len()),
            terminated: Rows::new(count, 1),
            truncated: Rows::new(count, 1),
            flat,
        }
    }

    /// Where the observations lie, part by part, or the flat one.
    #[must_use]
    pub fn observations(&self) -> Vec<Pointer> {
        self.observations.iter().map(Numbers::pointer).collect()
    }

    /// Where the last observations of episodes lie, with [`Autoreset::SameStep`].
    #[must_use]
    pub fn finals(&self) -> Vec<Pointer> {
        self.finals.iter().map(Numbers::pointer).collect()
    }

    /// Where the rewards lie.
    #[must_use]
    pub fn rewards(&self) -> Pointer {
        Pointer::F64(self.rewards.pointer(), 1)
    }

    /// Where the terms of the rewards lie, in the order of [`TERMS`].
    #[must_use]
    pub fn terms(&self) -> Pointer {
        Pointer::F64(self.terms.pointer(), TERMS.len())
    }

    /// Where the flags lie that tell which episodes have ended by what the vehicle did.
    #[must_use]
    pub fn terminated(&self) -> Pointer {
        Pointer::Bool(self.terminated.pointer(), 1)
    }

    /// Where the flags lie that tell which episodes have ended by something else.
    #[must_use]
    pub fn truncated(&self) -> Pointer {
        Pointer::Bool(self.truncated.pointer(), 1)
    }

    /// Writes an environment's observation.
    ///
    /// # Safety
    /// Nobody else uses the rows of this index.
    pub(crate) unsafe fn observe(&self, index: usize, env: &Env) {
        // SAFETY: as the caller promises.
        unsafe { self.fill(&self.observations, index, env) }
    }

    /// Writes the last observation of an environment's episode, with [`Autoreset::SameStep`].
    ///
    /// # Safety
    /// Nobody else uses the rows of this index.
    pub(crate) unsafe fn observe_last(&self, index: usize, env: &Env) {
        // SAFETY: as the caller promises.
        unsafe { self.fill(&self.finals, index, env) }
    }

    /// # Safety
    /// Nobody else uses the rows of this index.
    unsafe fn fill(&self, to: &[Numbers], index: usize, env: &Env) {
        for (part, numbers) in to.iter().enumerate() {
            // SAFETY: as the caller promises.
            let row = unsafe {
                match numbers {
                    Numbers::F32(rows) => Row::F32(rows.row(index)),
                    Numbers::U8(rows) => Row::U8(rows.row(index)),
                }
            };
            match row {
                Row::F32(row) if self.flat => env.observe_flat(row),
                row => env.observe(part, row),
            }
        }
    }

    /// Writes what a step came to.
    ///
    /// # Safety
    /// Nobody else uses the rows of this index.
    pub(crate) unsafe fn write(&self, index: usize, step: &Step) {
        // SAFETY: as the caller promises.
        unsafe {
            self.rewards.row(index)[0] = step.reward;
            self.terms.row(index).copy_from_slice(&step.terms);
            self.terminated.row(index)[0] = step.terminated;
            self.truncated.row(index)[0] = step.truncated;
        }
    }
}
