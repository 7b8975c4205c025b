//! The spinning lidar: a column of beams that turns once in a period. Each column is measured from where the vehicle is at
//! that moment, so a scan from a moving vehicle is distorted as a real one is.

use super::{DT, Return, View};
use crate::V3;
use crate::frame::Frame;
use crate::mount::{self, Bodywork};
use crate::noise::{Outage, Seed, uniform_and_normal};
use crate::profile::LidarModel;
use crate::rays::Surface;
use std::f64::consts::{PI, TAU};
use vb_math::angle::radians;
use vb_math::rng::Stream;
use vb_sdk::{LidarInfo, LidarScan};

/// Dust, and whether the vehicle is in it.
#[derive(Clone, Debug)]
struct Dust {
    spells: Outage,
    /// 1/m.
    extinction: f64,
}

#[derive(Clone, Debug)]
pub(crate) struct Lidar {
    info: LidarInfo,
    /// Where the sensor is in the body frame.
    place: Frame,
    /// Samples in a turn.
    turn: u64,
    range_std: f64,
    dropout: [f64; 2],
    dust: Option<Dust>,
    /// One draw for each beam, whether or not it hits.
    stream: Stream,
    /// Sine and cosine of the elevation of each row.
    rows: Vec<(f64, f64)>,
    /// For each beam, in the order of a scan, whether the vehicle itself is in its way.
    hidden: Vec<bool>,
    ranges: Vec<f32>,
    next: usize,
    scan: Option<LidarScan>,
}

impl Lidar {
    pub(crate) fn new(model: &LidarModel, every: u64, body: &Bodywork, scale: f64, seed: &Seed) -> Self {
        let info = LidarInfo {
            period: every as f64 * DT,
            rows: model.rows,
            cols: model.cols,
            lowest: radians(model.lowest_deg),
            highest: radians(model.highest_deg),
            min_range: model.min_range_m * scale,
            max_range: model.max_range_m * scale,
            mount: body.mount(&model.mount, scale),
        };
        let place = mount::frame(&info.mount);
        let between =
            if info.rows > 1 { (info.highest - info.lowest) / f64::from(info.rows - 1) } else { 0.0 };
        let rows: Vec<(f64, f64)> =
            (0..info.rows).map(|r| vb_math::sin_cos(info.lowest + f64::from(r) * between)).collect();
        let mut hidden = Vec::with_capacity(rows.len() * info.cols as usize);
        for elevation in &rows {
            for col in 0..info.cols {
                let direction = place.turn * beam(*elevation, azimuth(&info, col as usize));
                hidden.push(body.hides(&place.at, &direction, info.max_range));
            }
        }
        let dust = model.dust.map(|d| {
            let s = d.spells;
            let stream = seed.stream("lidar", "dust");
            let spells = Outage::new(s.mean_interval_s, s.mean_duration_s, DT, stream);
            Dust { spells, extinction: d.extinction_per_m / scale }
        });
        Self {
            place,
            turn: every,
            range_std: model.range_std_m * scale,
            dropout: [model.dropout_near, model.dropout_far],
            dust,
            stream: seed.stream("lidar", "beams"),
            ranges: vec![0.0; hidden.len()],
            rows,
            hidden,
            next: 0,
            scan: None,
            info,
        }
    }

    pub(crate) fn info(&self) -> &LidarInfo {
        &self.info
    }

    /// Probability that nothing comes back from a distance.
    fn loss(&self, range: f64) -> f64 {
        let [near, far] = self.dropout;
        let share = range / self.info.max_range;
        let plain = near + (far - near) * share * share;
        match &self.dust {
            // There and back, by the law of Beer and Lambert.
            Some(d) if d.spells.is_out() => 1.0 - (1.0 - plain) * vb_math::exp(-2.0 * d.extinction * range),
            _ => plain,
        }
    }

    /// Measures the columns that are due between the last sample and sample `k`, while the vehicle moves from `before` to
    /// `now`, and tells `each` of what it has measured.
    pub(crate) fn sample(
        &mut self,
        k: u64,
        (before, now): (&Frame, &Frame),
        time: f64,
        view: View<'_>,
        mut each: impl FnMut(Return),
    ) {
        if let Some(dust) = &mut self.dust {
            dust.spells.step();
        }
        if k == 0 {
            return;
        }
        let cols = self.info.cols as usize;
        // Samples of this turn that are over, and the time in samples at which a column is measured.
        let turn = self.turn as f64;
        let over = ((k - 1) % self.turn) as f64;
        let at = |col: usize| (col as f64 + 0.5) / cols as f64 * turn;
        while self.next < cols && at(self.next) <= over + 1.0 {
            let share = at(self.next) - over;
            let vehicle = before.towards(now, share);
            self.column(self.next, &vehicle, share, view, &mut each);
            self.next += 1;
        }
        if k.is_multiple_of(self.turn) {
            self.scan = Some(LidarScan { time, ranges: self.ranges.clone() });
            self.next = 0;
        }
    }

    fn column(
        &mut self,
        col: usize,
        vehicle: &Frame,
        share: f64,
        view: View<'_>,
        each: &mut impl FnMut(Return),
    ) {
        let azimuth = azimuth(&self.info, col);
        let sensor = vehicle.then(&self.place);
        let turn = sensor.turn.to_rotation_matrix();
        let (low, high) = (self.info.min_range, self.info.max_range);
        // The column's plane, seen from above in the sensor's frame.
        let (s, c) = azimuth;
        let mut fan =
            view.scene.fan(&sensor.at, &(turn * V3::new(-s, c, 0.0)), &(turn * V3::new(c, s, 0.0)), high);
        let noisy = self.range_std > 0.0 || self.dropout != [0.0; 2] || self.dust.is_some();
        for row in 0..self.rows.len() {
            let direction = beam(self.rows[row], azimuth);
            let beam = row * self.info.cols as usize + col;
            let (u, n) = if noisy { uniform_and_normal(&mut self.stream) } else { (1.0, 0.0) };
            self.ranges[beam] = 0.0;
            if self.hidden[beam] {
                continue;
            }
            let Some(hit) = fan.cast(&(turn * direction), view.ruts) else { continue };
            let range = hit.distance + self.range_std * n;
            if hit.distance < low || range < low || (noisy && u < self.loss(hit.distance)) {
                continue;
            }
            self.ranges[beam] = range as f32;
            each(Return {
                at: self.place.point(&(direction * range)),
                share,
                obstacle: hit.surface != Surface::Ground,
                label: None,
            });
        }
    }

    /// The last turn since the last call, if one has ended.
    pub(crate) fn take(&mut self) -> Option<LidarScan> {
        self.scan.take()
    }
}

/// Sine and cosine of the azimuth of a column.
fn azimuth(info: &LidarInfo, col: usize) -> (f64, f64) {
    vb_math::sin_cos((col as f64 + 0.5) / f64::from(info.cols) * TAU - PI)
}

/// The direction of a beam in the sensor's frame, by the sines and cosines of its elevation and its azimuth.
fn beam((up, flat): (f64, f64), (s, c): (f64, f64)) -> V3 {
    V3::new(flat * c, flat * s, up)
}
