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

use crate::aim::{Aim, Measure};
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
/// The share of tries that begin at any state and not at the most promising one.
const ANYWHERE: f64 = 0.3;

struct Reached {
    snapshot: Snapshot,
    /// The state from which it was reached, and the actions of the way from there.
    before: Option<(usize, Vec<[f64; 2]>)>,
    pieces: usize,
    /// What it is worth, as [`Aim::promise`] counts it.
    promise: f64,
    tries: usize,
}

/// The best drive that a search has found.
pub(crate) struct Best {
    /// Its value, in the unit of the aim.
    pub(crate) value: f64,
    /// Its actions, ten a second.
    pub(crate) actions: Vec<[f64; 2]>,
    /// How the episode ends with it, if it does.
    pub(crate) ended: Option<Outcome>,
}

pub(crate) struct Found {
    pub(crate) best: Best,
    /// The value at the start.
    pub(crate) start: f64,
    /// The actions of a drive that the simulator gives up as diverged.
    pub(crate) diverged: Option<Vec<[f64; 2]>>,
    /// Pieces of driving that were tried.
    pub(crate) pieces: usize,
}

/// Searches for the drive of a task that comes farthest in an aim, with so many pieces of driving at most. A search for the goal ends
/// where it is reached.
///
/// # Errors
/// Returns an error if the task can't be begun, or its maps aren't known.
pub(crate) fn search(arena: &Arc<Arena>, task: &TaskId, most: usize, aim: Aim) -> Result<Found, EnvError> {
    let mut env = Env::new(Arc::clone(arena), 0);
    env.reset(&Reset { task: Some(task.clone()), run_seed: Some(0), seed: None })?;
    let measure = Measure::new(&env, aim)?;
    let brief = env.brief().ok_or(EnvError::NoEpisode)?;
    let scale = brief.vehicle.scale;
    let limit = (brief.time_limit * 10.0 / PIECE as f64) as usize;
    let state = env.vehicle().ok_or(EnvError::NoEpisode)?;
    let start = measure.value(&env, None);
    let promise = aim.promise(start);
    let mut reached = vec![Reached { snapshot: env.snapshot(), before: None, pieces: 0, promise, tries: 0 }];
    let mut cells = BTreeMap::from([(cell(&state, scale), 0)]);
    let mut random = Stream::new(0, &["task search", task.as_str()]);
    let mut found = Found {
        best: Best { value: start, actions: Vec::new(), ended: None },
        start,
        diverged: None,
        pieces: most,
    };
    for tried in 1..=most {
        let from = choose(&reached, aim, &mut random);
        reached[from].tries += 1;
        let piece = Piece::draw(&mut random);
        env.restore(&reached[from].snapshot)?;
        let (own, ended) = match piece.drive(&mut env, measure.way()) {
            (own, Err(e)) if e.is_divergence() => {
                found.diverged.get_or_insert_with(|| actions(&reached, from, own));
                continue;
            }
            (own, ended) => (own, ended?),
        };
        let value = measure.value(&env, ended);
        let is_done = aim == Aim::Goal && ended == Some(Outcome::Success);
        if is_done || value > found.best.value {
            found.best = Best { value, actions: actions(&reached, from, own.clone()), ended };
        }
        if is_done {
            found.pieces = tried;
            break;
        }
        let pieces = reached[from].pieces + 1;
        let Some(state) = env.vehicle().filter(|_| ended.is_none() && pieces < limit) else { continue };
        let (cell, promise) = (cell(&state, scale), aim.promise(value));
        // A state that is replaced stays where it is, so that the ways of those that came of it hold.
        let is_better = |known: &Reached| match aim {
            Aim::Goal => pieces < known.pieces,
            _ => promise > known.promise,
        };
        if cells.get(&cell).is_none_or(|index| is_better(&reached[*index])) {
            cells.insert(cell, reached.len());
            let before = Some((from, own));
            reached.push(Reached { snapshot: env.snapshot(), before, pieces, promise, tries: 0 });
        }
    }
    Ok(found)
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

/// The state to go on from: the most promising one after what earlier tries and time cost, or now and then any.
fn choose(reached: &[Reached], aim: Aim, random: &mut Stream) -> usize {
    let (anywhere, which) = (random.unit() < ANYWHERE, random.below(reached.len() as u64) as usize);
    if anywhere {
        return which;
    }
    let promise = |r: &Reached| r.tries as f64 + aim.second() * r.pieces as f64 - r.promise;
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
    fn drive(&self, env: &mut Env, way: &Way) -> (Vec<[f64; 2]>, Result<Option<Outcome>, EnvError>) {
        let (slowest, fastest) = (SPEEDS[0], SPEEDS[SPEEDS.len() - 1]);
        let speed = 2.0 * (self.speed - slowest) / (fastest - slowest) - 1.0;
        let mut actions = Vec::with_capacity(PIECE);
        for _ in 0..PIECE {
            let led = if self.is_led { Self::led(env, way) } else { 0.0 };
            let action = [(led + self.steering).clamp(-1.0, 1.0), speed];
            actions.push(action);
            match env.step(&action) {
                Ok(step) if step.terminated || step.truncated => {
                    return (actions, Ok(env.record().map(|record| record.outcome)));
                }
                Ok(_) => {}
                Err(e) => return (actions, Err(e)),
            }
        }
        (actions, Ok(None))
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
        let found = search(&arena, &id("w001/t00"), 1000, Aim::Goal).unwrap();
        assert_eq!(found.best.ended, Some(Outcome::Success));
        let actions = found.best.actions;
        let record = repeat(&arena, &id("w001/t00"), &actions).unwrap().record().cloned().unwrap();
        assert_eq!(record.outcome, Outcome::Success);
        // A second search finds the same, and actions mean what they say.
        let again = search(&arena, &id("w001/t00"), 1000, Aim::Goal).unwrap();
        assert_eq!((&again.best.actions, again.pieces), (&actions, found.pieces));
        assert!(actions.iter().flatten().all(|a| (-1.0..=1.0).contains(a)));
    }

    #[test]
    fn who_may_try_little_finds_nothing_and_says_how_far_it_came() {
        let found = search(&arena(), &id("w001/t00"), 3, Aim::Goal).unwrap();
        assert!(found.best.ended.is_none() && found.pieces == 3);
        let left = found.best.value / found.start;
        assert!(left > 0.5 && left <= 1.0, "{left}");
        assert!(search(&arena(), &id("w001/t99"), 3, Aim::Goal).is_err());
    }

    #[test]
    fn what_a_search_finds_has_its_value_when_it_is_driven_anew() {
        let arena = arena();
        for aim in [Aim::Energy, Aim::Load, Aim::Idle] {
            let found = search(&arena, &id("w001/t00"), 30, aim).unwrap();
            assert!(found.best.value > found.start, "{aim:?}: {} {}", found.best.value, found.start);
            let mut env = Env::new(Arc::clone(&arena), 0);
            env.reset(&Reset { task: Some(id("w001/t00")), run_seed: Some(0), seed: None }).unwrap();
            let measure = Measure::new(&env, aim).unwrap();
            let env = repeat(&arena, &id("w001/t00"), &found.best.actions).unwrap();
            assert_eq!(measure.value(&env, found.best.ended), found.best.value, "{aim:?}");
        }
    }
}
