//! Where panels stand in a frame.

use vb_render::Size;

use crate::film::FilmError;

/// Panels in a frame at most.
pub(crate) const MOST: usize = 12;
/// Pixels between panels.
const GAP: u32 = 2;
/// Pixels that a panel has across and down at least.
const LEAST: u32 = 64;
/// The width of a panel over its height that is liked best.
const LIKED: f64 = 1.5;

/// Where panels stand in a frame: all of one size, row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layout {
    pub(crate) columns: u32,
    pub(crate) panel: Size,
}

impl Layout {
    pub(crate) fn new(runs: usize, frame: Size) -> Result<Self, FilmError> {
        if runs > MOST {
            return Err(FilmError::Runs { runs, most: MOST });
        }
        let n = runs.max(1) as u32;
        let side = |whole: u32, parts: u32| whole.saturating_sub(GAP * (parts - 1)) / parts;
        let of = |columns: u32| Size {
            width: side(frame.width, columns),
            height: side(frame.height, n.div_ceil(columns)),
        };
        // How far a panel's shape is from the one that is liked, worse by the part of the frame that stays empty.
        let cost = |columns: u32| {
            let panel = of(columns);
            let shape = f64::from(panel.width) / f64::from(panel.height.max(1)) / LIKED;
            let cells = f64::from(columns * n.div_ceil(columns));
            shape.max(1.0 / shape.max(1e-9)) * cells / f64::from(n)
        };
        let columns = (1..=n).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(1);
        let panel = of(columns);
        if panel.width.min(panel.height) < LEAST {
            let Size { width, height } = frame;
            return Err(FilmError::Small { width, height, runs, least: LEAST });
        }
        Ok(Self { columns, panel })
    }

    /// The upper left corner of a panel in the frame, pixels from the left and from the top.
    pub(crate) fn corner(&self, panel: usize) -> [usize; 2] {
        let columns = self.columns as usize;
        let place = |n: usize, side: u32| n * (side + GAP) as usize;
        [place(panel % columns, self.panel.width), place(panel / columns, self.panel.height)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_fill_the_frame_and_do_not_overlap() {
        let frame = Size { width: 1280, height: 720 };
        let layout = |n| Layout::new(n, frame).unwrap();
        assert_eq!(layout(1), Layout { columns: 1, panel: frame });
        assert_eq!(layout(2), Layout { columns: 2, panel: Size { width: 639, height: 720 } });
        assert_eq!(layout(4), Layout { columns: 2, panel: Size { width: 639, height: 359 } });
        assert_eq!(layout(6).columns, 3);
        for n in 1..=MOST {
            let layout = layout(n);
            let mut taken = vec![false; 1280 * 720];
            for k in 0..n {
                let [x, y] = layout.corner(k);
                for row in y..y + layout.panel.height as usize {
                    for col in x..x + layout.panel.width as usize {
                        assert!(!std::mem::replace(&mut taken[1280 * row + col], true), "{n} {k}");
                    }
                }
            }
        }
        assert!(matches!(Layout::new(13, frame), Err(FilmError::Runs { runs: 13, most: MOST })));
        let small = Layout::new(12, Size { width: 200, height: 200 });
        assert!(matches!(small, Err(FilmError::Small { runs: 12, .. })));
    }
}
