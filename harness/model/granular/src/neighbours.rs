//! Neighbour lists of grains (Verlet lists), which remain valid until something has moved by half of the skin.

use crate::V3;
use crate::bed::Grains;
use crate::contact::Memory;
use crate::packing::Bin;
use crate::tool::{Motion, Shape, Tool};
use crate::walls::Walls;

/// Contact partner of a grain other than a grain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Other {
    Wall(u8),
    Tool(u8),
}

/// A grain that is near something.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near<T> {
    pub(crate) grain: u32,
    pub(crate) other: T,
    pub(crate) memory: Memory,
}

/// All grains near each other, and near walls and tools, in the order of grains and of what they are near.
#[derive(Clone, Debug)]
pub(crate) struct Neighbours {
    /// Pairs of grains of which at least one moves.
    pub(crate) grains: Vec<Near<u32>>,
    /// Walls and tools near grains that move.
    pub(crate) others: Vec<Near<Other>>,
    /// Pairs of grains at rest, and walls near grains at rest.
    asleep: (Vec<Near<u32>>, Vec<Near<Other>>),
    /// Which grains move, by their numbers and one by one.
    pub(crate) moving: Vec<u32>,
    moves: Vec<bool>,
    /// Where grains and tools were when the list was made.
    places: Vec<V3>,
    tools: Vec<Motion>,
    /// Skin of the neighbour lists, m.
    skin: f64,
    /// Maximum diameter of a grain, m.
    diameter: f64,
    /// Distance from the tools beyond which grains at rest don't move, m.
    reach: f64,
    pub(crate) period: Period,
}

/// Distances along x and y after which the grains repeat themselves, m; none in a bin with walls.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Period(Option<[f64; 2]>);

impl Period {
    pub(crate) fn of(bin: Bin) -> Self {
        Self(Some([bin.length, bin.width]))
    }

    /// The shortest of the ways between two grains.
    #[inline]
    pub(crate) fn nearest(self, mut way: V3) -> V3 {
        if let Some(period) = self.0 {
            for (k, p) in period.into_iter().enumerate() {
                way[k] -= p * (way[k] / p).round();
            }
        }
        way
    }

    /// Brings places back into the bin.
    fn wrap(self, places: &mut [V3]) {
        if self.0.is_some() {
            places.iter_mut().for_each(|x| *x = self.nearest(*x));
        }
    }

    /// Shows a place as it repeats itself around the bin, first where it is.
    fn images(self, x: V3, mut show: impl FnMut(V3)) {
        show(x);
        let Some([px, py]) = self.0 else { return };
        for (i, j) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
            show(x + V3::new(f64::from(i) * px, f64::from(j) * py, 0.0));
        }
    }
}

/// Speed below which a grain far from the tools comes to rest, m/s.
const REST: f64 = 0.02;

impl Neighbours {
    pub(crate) fn new(skin: f64, diameter: f64, reach: f64) -> Self {
        Self {
            grains: Vec::new(),
            others: Vec::new(),
            asleep: (Vec::new(), Vec::new()),
            moving: Vec::new(),
            moves: Vec::new(),
            places: Vec::new(),
            tools: Vec::new(),
            skin,
            diameter,
            reach,
            period: Period::default(),
        }
    }

    /// Rebuilds the lists if something has moved by half of the skin since the last time.
    pub(crate) fn update(&mut self, grains: &mut Grains, tools: &[Tool], motions: &[Motion], walls: &Walls) {
        let half = 0.25 * self.skin * self.skin;
        let is_near =
            |&i: &u32| (grains.position[i as usize] - self.places[i as usize]).norm_squared() < half;
        let holds = self.places.len() == grains.position.len()
            && self.tools.len() == motions.len()
            && motions
                .iter()
                .zip(&self.tools)
                .zip(tools)
                .all(|((now, before), tool)| now.moved_since(before, tool) < 0.5 * self.skin)
            && self.moving.iter().all(is_near);
        if !holds {
            self.period.wrap(&mut grains.position);
            self.places.clone_from(&grains.position);
            self.tools = motions.to_vec();
            let near = self.wake(grains, tools, motions);
            self.look(grains, &near, tools, motions, walls);
        }
    }

    /// Finds out which grains move, and stops the others. It returns those that may be neighbours of grains that move.
    fn wake(&mut self, grains: &mut Grains, tools: &[Tool], motions: &[Motion]) -> Vec<u32> {
        let count = grains.position.len();
        self.moving.clear();
        if self.reach.is_infinite() {
            self.moves = vec![true; count];
            self.moving.extend(0..count as u32);
            return self.moving.clone();
        }
        let contains = |[low, high]: &[V3; 2], x: &V3| (0..3).all(|k| x[k] > low[k] && x[k] < high[k]);
        let extents: Vec<[V3; 2]> =
            tools.iter().zip(motions).map(|(tool, motion)| tool.shape.extent(motion, self.reach)).collect();
        let empty = [V3::repeat(f64::INFINITY), V3::repeat(f64::NEG_INFINITY)];
        let around_tools = extents.iter().fold(empty, |[low, high], [l, h]| [low.inf(l), high.sup(h)]);
        let near = |x: &V3| {
            let within = |((tool, motion), extent): ((&Tool, &Motion), &[V3; 2])| {
                contains(extent, x) && tool.shape.may_reach(x, motion, self.reach)
            };
            contains(&around_tools, x) && tools.iter().zip(motions).zip(&extents).any(within)
        };
        self.moves.clear();
        let mut moving = empty;
        for i in 0..count {
            let x = grains.position[i];
            let moves = grains.velocity[i].norm_squared() > REST * REST || near(&x);
            self.moves.push(moves);
            if moves {
                self.moving.push(i as u32);
                moving = [moving[0].inf(&x), moving[1].sup(&x)];
            } else {
                (grains.velocity[i], grains.spin[i]) = (V3::zeros(), V3::zeros());
            }
        }
        let reach = V3::repeat(self.diameter + self.skin);
        let around_moving = [moving[0] - reach, moving[1] + reach];
        (0..count as u32).filter(|&i| contains(&around_moving, &grains.position[i as usize])).collect()
    }

    fn look(&mut self, grains: &Grains, near: &[u32], tools: &[Tool], motions: &[Motion], walls: &Walls) {
        let moves = &self.moves;
        let cells = Cells::new(&grains.position, near, self.diameter + self.skin);
        let before = merged(std::mem::take(&mut self.grains), std::mem::take(&mut self.asleep.0));
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for &i in &self.moving {
            let x = grains.position[i as usize];
            let reach = grains.radius[i as usize] + self.skin;
            self.period.images(x, |x| {
                cells.around(&x, |j| {
                    let within = reach + grains.radius[j as usize];
                    let is_new = j > i || (j < i && !moves[j as usize]);
                    if is_new && (grains.position[j as usize] - x).norm_squared() < within * within {
                        pairs.push((i.min(j), i.max(j)));
                    }
                });
            });
        }
        pairs.sort_unstable();
        self.grains = remembered(pairs.into_iter(), &before);
        let rests = |near: &Near<u32>| !moves[near.grain as usize] && !moves[near.other as usize];
        self.asleep.0 = before.into_iter().filter(rests).collect();

        let before = merged(std::mem::take(&mut self.others), std::mem::take(&mut self.asleep.1));
        let near = self.moving.iter().flat_map(|&i| {
            let x = grains.position[i as usize];
            let reach = grains.radius[i as usize] + self.skin;
            let near_wall = move |wall: &u8| walls.distance(*wall, &x).0 < reach;
            let near_walls = (0..walls.count).filter(near_wall).map(Other::Wall);
            let is_near = move |k: &usize| {
                let (tool, motion) = (&tools[*k], &motions[*k]);
                tool.shape.may_reach(&x, motion, reach)
                    && tool.shape.distance(&(motion.rotation.inverse() * (x - motion.position))).0 < reach
            };
            let tools = (0..tools.len().min(motions.len())).filter(is_near).map(|k| Other::Tool(k as u8));
            near_walls.chain(tools).map(move |other| (i, other))
        });
        self.others = remembered(near, &before);
        self.asleep.1 = before.into_iter().filter(|near| !moves[near.grain as usize]).collect();
    }
}

/// Two lists as one, in the order of both.
fn merged<T: Copy + Ord>(mut a: Vec<Near<T>>, b: Vec<Near<T>>) -> Vec<Near<T>> {
    a.extend(b);
    a.retain(|near| near.memory != Memory::default());
    a.sort_unstable_by_key(|near| (near.grain, near.other));
    a
}

/// A list of contacts that remember what they did in another; both are in order.
fn remembered<T: Copy + Ord>(keys: impl Iterator<Item = (u32, T)>, before: &[Near<T>]) -> Vec<Near<T>> {
    let mut old = before.iter().peekable();
    keys.map(|(grain, other)| {
        while old.next_if(|near| (near.grain, near.other) < (grain, other)).is_some() {}
        let same = old.next_if(|near| (near.grain, near.other) == (grain, other));
        Near { grain, other, memory: same.map_or_else(Memory::default, |near| near.memory) }
    })
    .collect()
}

impl Motion {
    /// Upper bound of the displacement of a tool's surface since an earlier motion, m. The spin of a wheel displaces nothing.
    fn moved_since(&self, before: &Self, tool: &Tool) -> f64 {
        let turned = match &tool.shape {
            Shape::Wheel { radius, width, .. } => {
                let axes = [self, before].map(|motion| motion.rotation * V3::y());
                (axes[0] - axes[1]).norm() * (radius + width)
            }
            shape => self.rotation.rotation_to(&before.rotation).imag().norm() * 2.0 * shape.bound(),
        };
        (self.position - before.position).norm() + turned
    }
}

/// Grains by cells of a grid.
struct Cells {
    low: V3,
    side: f64,
    counts: [usize; 3],
    /// Where the grains of each cell begin in `grains`.
    starts: Vec<u32>,
    grains: Vec<u32>,
}

impl Cells {
    /// Cells of the grains with these numbers.
    fn new(positions: &[V3], numbers: &[u32], side: f64) -> Self {
        let places = || numbers.iter().map(|&i| positions[i as usize]);
        let low = places().fold(V3::repeat(f64::INFINITY), |low, x| low.inf(&x));
        let high = places().fold(V3::repeat(f64::NEG_INFINITY), |high, x| high.sup(&x));
        // A grain that is thrown far away must not make the grid large.
        const MOST: f64 = 512.0;
        let counts = [0, 1, 2].map(|k| (((high[k] - low[k]) / side).clamp(0.0, MOST) as usize) + 1);
        let mut cells = Self {
            low,
            side,
            counts,
            starts: vec![0; counts.iter().product::<usize>() + 1],
            grains: vec![0; numbers.len()],
        };
        let of: Vec<usize> = places().map(|x| cells.index(cells.cell(&x))).collect();
        for &cell in &of {
            cells.starts[cell + 1] += 1;
        }
        for cell in 1..cells.starts.len() {
            cells.starts[cell] += cells.starts[cell - 1];
        }
        let mut next = cells.starts.clone();
        for (&grain, &cell) in numbers.iter().zip(&of) {
            cells.grains[next[cell] as usize] = grain;
            next[cell] += 1;
        }
        cells
    }

    fn cell(&self, x: &V3) -> [usize; 3] {
        [0, 1, 2].map(|k| (((x[k] - self.low[k]) / self.side).max(0.0) as usize).min(self.counts[k] - 1))
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    /// Shows all grains in the cell of a point and the cells around it; none of a point more than a cell outside of the grid.
    fn around(&self, x: &V3, mut show: impl FnMut(u32)) {
        let beyond = |k: usize| {
            let place = (x[k] - self.low[k]) / self.side;
            place < -1.0 || place > self.counts[k] as f64 + 1.0
        };
        if beyond(0) || beyond(1) {
            return;
        }
        let [cx, cy, cz] = self.cell(x);
        let span = |c: usize, k: usize| c.saturating_sub(1)..(c + 2).min(self.counts[k]);
        for z in span(cz, 2) {
            for y in span(cy, 1) {
                let xs = span(cx, 0);
                let (first, last) = (self.index([xs.start, y, z]), self.index([xs.end - 1, y, z]));
                let (from, to) = (self.starts[first] as usize, self.starts[last + 1] as usize);
                self.grains[from..to].iter().for_each(|&grain| show(grain));
            }
        }
    }
}
