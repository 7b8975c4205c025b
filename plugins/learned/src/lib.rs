//! A planner that drives by a policy's weights, which are put into its file after it was built: so whoever trains a policy in Python
//! needs no Rust to hand it in.
//!
//! The static `SLOT` is room for them. `python -m vertibench.training package` finds it by its first bytes, writes the length and the weights
//! behind these, and puts name and weights into the planner's metadata (`harness/python/vertibench/training/_package.py`).

use vb_sdk::nn::Weights;
use vb_sdk::policy::Trained;
use vb_sdk::{Command, Observation, Planner, PlannerError, Task};

vb_sdk::export_planner! {
    planner: Learned,
    name: "learned",
    about: "Drives by the weights of a policy, once there are some in its file",
    control_period: 0.1,
}

/// The most bytes of weights: a quarter million numbers.
pub const CAPACITY: usize = 1 << 20;
/// The bytes by which the room for weights is found; the length follows in four bytes, the lowest first.
pub const MARK: [u8; 32] = *b"vertibench: room for weights ->\n";

/// The room for weights: the mark, the length, and then the weights. What isn't zero is in the file byte for byte.
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

/// What is in the room now. The compiler must not take it for what it was when this was built.
fn weights() -> Vec<u8> {
    // SAFETY: the index lies in the array.
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
            let to_do = "take weights that `python -m vertibench.training export` has written, and put them in by `… package`";
            return Err(format!("there are no weights in this planner's file ({to_do})").into());
        }
        let policy = Trained::new(&Weights::parse(&weights)?, task)?;
        Ok(Self { task: task.clone(), policy })
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, PlannerError> {
        self.policy.step(&self.task, observation)
    }
}
