//! The map of the surroundings: what lidar and depth camera have hit, put where the estimated pose says that it is.
//!
//! The map is a square of cells that stand still in the frame of the estimate. When the vehicle has come into the next cell,
//! the map moves on by a cell: what falls out is forgotten, and what comes in is unknown. So a drift of the estimate smears
//! what was seen before against what is seen now, as on a real vehicle. The height of a cell is the mean of the hits on
//! ground within it, in which the last `memory` hits have most of the weight. A cell counts as occupied once a hit within
//! it was on an obstacle; such hits don't count for the height. The class is the one that most of the camera's hits on
//! ground had (Boyer and Moore, "MJRTY – a fast majority vote algorithm", 1991, which takes one label and one number).

use super::Return;
use crate::V3;
use crate::frame::Frame;
use crate::profile::{LocalMapModel, OBSTACLE, UNKNOWN};
use vb_sdk::{GridFrame, LocalMap, Map};

#[derive(Clone, Copy, Debug)]
struct Cell {
    height: f32,
    hits: u32,
    label: u8,
    votes: u8,
    occupancy: u8,
}

const UNSEEN: Cell = Cell { height: f32::NAN, hits: 0, label: UNKNOWN, votes: 0, occupancy: UNKNOWN };

/// The map under construction.
#[derive(Clone, Debug)]
pub(crate) struct Mapper {
    /// Samples from one map to the next.
    every: u64,
    count: i64,
    resolution: f64,
    memory: u32,
    /// Column and row of the south-western cell, counted from the world's centre; none before the first sample.
    corner: Option<[i64; 2]>,
    cells: Vec<Cell>,
    map: Option<LocalMap>,
}

impl Mapper {
    pub(crate) fn new(model: &LocalMapModel, every: u64, scale: f64) -> Self {
        let count = (model.side_m / model.resolution_m).round() as i64;
        Self {
            every,
            count,
            resolution: model.resolution_m * scale,
            memory: model.memory,
            corner: None,
            cells: vec![UNSEEN; (count * count) as usize],
            map: None,
        }
    }

    /// Brings the vehicle, by the estimate, into the middle.
    pub(crate) fn move_to(&mut self, at: &V3) {
        // The vehicle is in one of the two (or four) cells about the middle: that of the nearest side between cells.
        let middle = |v: f64| (v / self.resolution + 0.5).floor() as i64 - self.count / 2;
        let corner = [middle(at.x), middle(at.y)];
        let Some(old) = self.corner.replace(corner) else { return };
        if old == corner {
            return;
        }
        let mut moved = vec![UNSEEN; self.cells.len()];
        for row in 0..self.count {
            for col in 0..self.count {
                let (r, c) = (row + corner[1] - old[1], col + corner[0] - old[0]);
                if (0..self.count).contains(&r) && (0..self.count).contains(&c) {
                    moved[(row * self.count + col) as usize] = self.cells[(r * self.count + c) as usize];
                }
            }
        }
        self.cells = moved;
    }

    /// Adds what was measured from where the estimate says that the vehicle was.
    pub(crate) fn add(&mut self, hit: &Return, vehicle: &Frame) {
        let Some(corner) = self.corner else { return };
        let at = vehicle.point(&hit.at);
        let col = (at.x / self.resolution).floor() as i64 - corner[0];
        let row = (at.y / self.resolution).floor() as i64 - corner[1];
        if !(0..self.count).contains(&col) || !(0..self.count).contains(&row) {
            return;
        }
        let cell = &mut self.cells[(row * self.count + col) as usize];
        if hit.obstacle {
            cell.occupancy = 1;
            return;
        }
        if cell.occupancy == UNKNOWN {
            cell.occupancy = 0;
        }
        cell.hits = (cell.hits + 1).min(self.memory);
        let z = at.z as f32;
        cell.height = if cell.hits == 1 { z } else { cell.height + (z - cell.height) / cell.hits as f32 };
        if let Some(label) = hit.label.filter(|l| *l < OBSTACLE) {
            if cell.label == label {
                cell.votes = cell.votes.saturating_add(1);
            } else if cell.votes > 0 {
                cell.votes -= 1;
            } else {
                (cell.label, cell.votes) = (label, 1);
            }
        }
    }

    /// Makes the map at sample `k` if one is due.
    pub(crate) fn finish(&mut self, k: u64, time: f64) {
        let Some(corner) = self.corner.filter(|_| k.is_multiple_of(self.every)) else { return };
        let origin = |k: usize| (corner[k] as f64 + 0.5) * self.resolution;
        let frame = GridFrame {
            rows: self.count as u32,
            cols: self.count as u32,
            resolution: self.resolution,
            origin_x: origin(0),
            origin_y: origin(1),
        };
        self.map = Some(LocalMap {
            time,
            elevation: Map { frame, data: self.cells.iter().map(|c| c.height).collect() },
            semantics: Map { frame, data: self.cells.iter().map(|c| c.label).collect() },
            occupancy: Map { frame, data: self.cells.iter().map(|c| c.occupancy).collect() },
        });
    }

    /// The last map since the last call, if there is a new one.
    pub(crate) fn take(&mut self) -> Option<LocalMap> {
        self.map.take()
    }
}
