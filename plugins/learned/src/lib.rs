//! A planner that runs the weights of a policy, which are embedded in its file after compilation: policies trained in
//! Python become planners without Rust.
//!
//! The static `SLOT` reserves the space. `python -m vertibench.training package` finds it by its first bytes, writes
//! the length and the weights after them, and puts name and weights into the planner's metadata
//! (`harness/python/vertibench/training/_package.py`).

use vb_sdk::nn::Weights;
use vb_sdk::policy::Trained;
use vb_sdk::{Command, Observation, Planner, PlannerError, Task};

vb_sdk::export_planner! {
    planner: Learned,
    name: "learned",
    about: "Runs an embedded policy",
    control_period: 0.1,
}

/// Maximum size of the weights, bytes (a quarter of a million numbers).
pub const CAPACITY: usize = 1 << 20;
/// Marker of the reserved space; the length follows as a little-endian number of four bytes.
pub const MARK: [u8; 32] = *b"vertibench: room for weights ->\n";

/// Reserved space: marker, length, weights. It is not zero, so that the file contains it byte for byte.
#[used]
static SLOT: [u8; MARK.len() + 4 + CAPACITY] = empty();

const fn empty() -> [u8; MARK.len() + 4 + CAPACITY] {
    let mut slot = [0xff; MARK.len() + 4 + CAPACITY];
    let mut k = 0;
    while k < MARK.len() + 4 {
        slot[k] = if k < MARK.len() { MARK[k] } else { 0 };
        k += 1;
    }
    slot
}

/// The current content of the space. Volatile reads, because the file changes after compilation.
fn weights() -> Vec<u8> {
    // SAFETY: the index is within the array.
    let at = |k: usize| unsafe { std::ptr::read_volatile(&raw const SLOT[k]) };
    let start = MARK.len();
    let length = u32::from_le_bytes(std::array::from_fn(|k| at(start + k))) as usize;
    (0..length.min(CAPACITY)).map(|k| at(start + 4 + k)).collect()
}

pub struct Learned {
    task: Task,
    policy: Trained,
}

impl Planner for Learned {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let weights = weights();
        if weights.is_empty() {
            let to_do = "export weights using `python -m vertibench.training export`, and embed them using `… package`";
            return Err(format!("this planner contains no weights ({to_do})").into());
        }
        let policy = Trained::new(&Weights::parse(&weights)?, task)?;
        Ok(Self { task: task.clone(), policy })
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, PlannerError> {
        self.policy.step(&self.task, observation)
    }
}
