//! The search: an archive of states that were reached, from which ever new pieces of driving are tried.
//!
//! It remembers the first state in each cell of places, headings and speeds, and any that comes there sooner; goes back to a promising
//! one; and drives on from there at random (Ecoffet et al., "First return, then explore", Nature 590, 2021). A task that it does can be
//! done; of one that it doesn't, nothing is proven.

use std::collections::BTreeMap;
use std::sync::Arc;

use vb_env::{Arena, Env, EnvError, Reset, Snapshot};
use vb_math::rng::Stream;
use vb_score::Outcome;
use vb_sim::VehicleState;
use vb_world::TaskId;

use crate::way::Way;

/// Actions of a piece of driving, which is a second long at ten actions a second.
const PIECE: usize = 10;
/// Speeds that are tried, m/s at full scale.
pub(crate) const SPEEDS: [f64; 6] = [-2.5, 1.0, 2.5, 4.0, 6.0, 8.0];
/// Steerings that are tried.
const STEERINGS: [f64; 7] = [-1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0];
/// The share of pieces that steer where the way leads, how far ahead they look (m at full scale), and by how much each is aside.
const LED: f64 = 0.6;
const AHEAD: f64 = 5.0;
const ASIDE: f64 = 0.3;
/// Sides of a cell: m at full scale, rad, and m/s at full scale.
const CELL: [f64; 3] = [1.0, std::f64::consts::PI / 8.0, 2.0];
/// What each earlier try from a state counts for in the choice of the next, in metres of the way that is left.
const TRIED: f64 = 1.0;
/// What each second that has passed counts for, which prefers states that are far for their time.
const PASSED: f64 = 2.0;
/// The share of tries that begin at any state and not at the most promising one.
const ANYWHERE: f64 = 0.3;

struct Reached {
    snapshot: Snapshot,
    /// The state from which it was reached, and the actions of the way from there.
    before: Option<(usize, Vec<[f64; 2]>)>,
    pieces: usize,
    /// The cost of the way that is left, m.
    left: f64,
    tries: usize,
}

pub(crate) struct Found {
    /// The actions of a drive that does the task, ten a second; `None` if none was found.
    pub(crate) actions: Option<Vec<[f64; 2]>>,
    /// Pieces of driving that were tried.
    pub(crate) pieces: usize,
    /// The least cost of the way that was left, over that at the start.
    pub(crate) left: f64,
}

/// Searches for a drive that does a task, with so many pieces of driving at most.
///
/// # Errors
/// Returns an error if the task can't be begun, or its maps aren't known.
pub(crate) fn search(arena: &Arc<Arena>, task: &TaskId, most: usize) -> Result<Found, EnvError> {
    let mut env = Env::new(Arc::clone(arena), 0);
    env.reset(&Reset { task: Some(task.clone()), run_seed: Some(0), seed: None })?;
    let missing = || EnvError::Observation("maps of heights and obstacles are needed".into());
    let brief = env.brief().ok_or(EnvError::NoEpisode)?;
    let way = Way::new(brief).ok_or_else(missing)?;
    let scale = brief.vehicle.scale;
    let limit = (brief.time_limit * 10.0 / PIECE as f64) as usize;
    let start = env.vehicle().ok_or(EnvError::NoEpisode)?;
    let all = way.left(start.position.x, start.position.y);
    let mut reached =
        vec![Reached { snapshot: env.snapshot(), before: None, pieces: 0, left: all, tries: 0 }];
    let mut cells = BTreeMap::from([(cell(&start, scale), 0)]);
    let mut random = Stream::new(0, &["task search", task.as_str()]);
    let mut least = all;
    for tried in 1..=most {
        let from = choose(&reached, &mut random);
        reached[from].tries += 1;
        let piece = Piece::draw(&mut random);
        env.restore(&reached[from].snapshot)?;
        let (own, ended) = piece.drive(&mut env, &way)?;
        if ended == Some(Outcome::Success) {
            let actions = Some(actions(&reached, from, own));
            return Ok(Found { actions, pieces: tried, left: 0.0 });
        }
        let pieces = reached[from].pieces + 1;
        let Some(state) = env.vehicle().filter(|_| ended.is_none() && pieces < limit) else { continue };
        let left = way.left(state.position.x, state.position.y);
        least = least.min(left);
        let cell = cell(&state, scale);
        // A state that is replaced stays where it is, so that the ways of those that came of it hold.
        if cells.get(&cell).is_none_or(|index| pieces < reached[*index].pieces) {
            cells.insert(cell, reached.len());
            let before = Some((from, own));
            reached.push(Reached { snapshot: env.snapshot(), before, pieces, left, tries: 0 });
        }
    }
    Ok(Found { actions: None, pieces: most, left: least / all.max(1e-9) })
}

/// Drives a task anew by these actions; how it ends.
pub(crate) fn repeat(arena: &Arc<Arena>, task: &TaskId, actions: &[[f64; 2]]) -> Result<Env, EnvError> {
    let mut env = Env::new(Arc::clone(arena), 0);
    env.reset(&Reset { task: Some(task.clone()), run_seed: Some(0), seed: None })?;
    for action in actions {
        let step = env.step(action)?;
        if step.terminated || step.truncated {
            break;
        }
    }
    Ok(env)
}

/// The state to go on from: the one with the least way left, time passed and tries, or now and then any.
fn choose(reached: &[Reached], random: &mut Stream) -> usize {
    let (anywhere, which) = (random.unit() < ANYWHERE, random.below(reached.len() as u64) as usize);
    if anywhere {
        return which;
    }
    let promise = |r: &Reached| r.left + TRIED * r.tries as f64 + PASSED * r.pieces as f64;
    let best = reached.iter().enumerate().min_by(|a, b| promise(a.1).total_cmp(&promise(b.1)));
    best.map_or(0, |(index, _)| index)
}

struct Piece {
    /// The steering, or how far aside of where the way leads.
    steering: f64,
    is_led: bool,
    /// m/s at full scale.
    speed: f64,
}

impl Piece {
    fn draw(random: &mut Stream) -> Self {
        let [led, steering, speed] = std::array::from_fn(|_| random.unit());
        let pick = |values: &[f64], draw: f64| values[(draw * values.len() as f64) as usize % values.len()];
        let is_led = led < LED;
        let steering = if is_led { ASIDE * (2.0 * steering - 1.0) } else { pick(&STEERINGS, steering) };
        Self { steering, is_led, speed: pick(&SPEEDS, speed) }
    }

    /// Drives it: the actions, and how the episode has ended, if it has.
    fn drive(&self, env: &mut Env, way: &Way) -> Result<(Vec<[f64; 2]>, Option<Outcome>), EnvError> {
        let (slowest, fastest) = (SPEEDS[0], SPEEDS[SPEEDS.len() - 1]);
        let speed = 2.0 * (self.speed - slowest) / (fastest - slowest) - 1.0;
        let mut actions = Vec::with_capacity(PIECE);
        for _ in 0..PIECE {
            let led = if self.is_led { Self::led(env, way) } else { 0.0 };
            let action = [(led + self.steering).clamp(-1.0, 1.0), speed];
            actions.push(action);
            let step = env.step(&action)?;
            if step.terminated || step.truncated {
                return Ok((actions, env.record().map(|record| record.outcome)));
            }
        }
        Ok((actions, None))
    }

    /// The steering to where the way leads.
    fn led(env: &Env, way: &Way) -> f64 {
        let (Some(state), Some(brief)) = (env.vehicle(), env.brief()) else { return 0.0 };
        let (_, _, yaw) = state.roll_pitch_yaw();
        let turn = way.turn([state.position.x, state.position.y], yaw, AHEAD * brief.vehicle.scale);
        turn / brief.vehicle.max_steer_angle
    }
}

/// The actions that lead to a state, and these after them.
fn actions(reached: &[Reached], mut at: usize, last: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut pieces = vec![&last];
    while let Some((before, piece)) = &reached[at].before {
        pieces.push(piece);
        at = *before;
    }
    pieces.into_iter().rev().flatten().copied().collect()
}

fn cell(state: &VehicleState, scale: f64) -> [i64; 4] {
    let (_, _, yaw) = state.roll_pitch_yaw();
    let p = state.position / scale;
    let whole = |v: f64, side: f64| (v / side).floor() as i64;
    [
        whole(p.x, CELL[0]),
        whole(p.y, CELL[0]),
        whole(yaw, CELL[1]),
        whole(state.velocity_body.x / scale.sqrt(), CELL[2]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use vb_catalog::Catalog;
    use vb_env::Options;
    use vb_sdk::policy::ActionKind;

    fn id(task: &str) -> TaskId {
        task.parse().unwrap()
    }

    /// Tasks of the small suite, which the harness brings along.
    fn arena() -> Arc<Arena> {
        let tasks = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tasks");
        let options = Options {
            suite: Some("smoke".into()),
            action: ActionKind::Speed { slowest: SPEEDS[0], fastest: SPEEDS[SPEEDS.len() - 1] },
            observation: vec!["state".into()],
            ..Options::default()
        };
        Arc::new(Arena::new(&Catalog::at(tasks), options, &mut || {}).unwrap())
    }

    #[test]
    fn an_easy_task_is_found_and_done_again() {
        let arena = arena();
        let found = search(&arena, &id("w001/t00"), 1000).unwrap();
        let actions = found.actions.expect("a way");
        let record = repeat(&arena, &id("w001/t00"), &actions).unwrap().record().cloned().unwrap();
        assert_eq!(record.outcome, Outcome::Success);
        // A second search finds the same, and actions mean what they say.
        let again = search(&arena, &id("w001/t00"), 1000).unwrap();
        assert_eq!((again.actions.as_ref(), again.pieces), (Some(&actions), found.pieces));
        assert!(actions.iter().flatten().all(|a| (-1.0..=1.0).contains(a)));
    }

    #[test]
    fn who_may_try_little_finds_nothing_and_says_how_far_it_came() {
        let found = search(&arena(), &id("w001/t00"), 3).unwrap();
        assert!(found.actions.is_none() && found.pieces == 3);
        assert!(found.left > 0.5 && found.left <= 1.0, "{}", found.left);
        assert!(search(&arena(), &id("w001/t99"), 3).is_err());
    }
}
