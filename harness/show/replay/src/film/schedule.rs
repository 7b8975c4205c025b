//! When frames are taken.

use crate::film::FilmError;

/// Frames of a video at most: half an hour at 30 frames a second.
const MOST: u64 = 54_000;
/// How long the end is shown, s of the video.
const HOLD: f64 = 1.0;

/// What part of the runs a video shows, and how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// The time of the first frame, s; 0 if it isn't said.
    pub from: Option<f64>,
    /// The time of the last frame, s; if it isn't said, the end of the run that took longest, which is then shown for a second.
    pub to: Option<f64>,
    /// The time that passes in the world while a second of the video does, s.
    pub speed: f64,
    /// The number of frames for each second of the video.
    pub fps: f64,
}

/// The moments that a video shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// The time of each frame, s.
    pub times: Vec<f64>,
    /// The number of frames for each second of the video.
    pub fps: f64,
}

impl Schedule {
    /// The moments of runs of which the last ended at `end`, s.
    ///
    /// # Errors
    /// Returns an error if `from` or `to` lies outside of the runs, if the one isn't before the other, or if there would be more
    /// frames than half an hour has.
    pub fn new(course: Course, end: f64) -> Result<Self, FilmError> {
        let Course { from, to, speed, fps } = course;
        let first = from.unwrap_or(0.0);
        if !(0.0..=end).contains(&first) {
            return Err(FilmError::Time { option: "--from", time: first, end });
        }
        let last = to.unwrap_or(end);
        if last < first {
            return Err(FilmError::Backwards { from: first, to: last });
        }
        if !(first..=end).contains(&last) {
            return Err(FilmError::Time { option: "--to", time: last, end });
        }
        let step = speed / fps;
        let held = if to.is_none() { (HOLD * fps).round() } else { 0.0 };
        let frames = ((last - first) / step).ceil() + 1.0 + held;
        if frames > MOST as f64 {
            return Err(FilmError::Long { frames: frames as u64, most: MOST });
        }
        let times = (0..frames as u64).map(|k| (first + k as f64 * step).min(last)).collect();
        Ok(Self { times, fps })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_even_and_the_end_is_held() {
        let all = Course { from: None, to: None, speed: 1.0, fps: 4.0 };
        let times = Schedule::new(all, 1.1).unwrap().times;
        assert_eq!(times, [0.0, 0.25, 0.5, 0.75, 1.0, 1.1, 1.1, 1.1, 1.1, 1.1]);
        let part = Course { from: Some(1.0), to: Some(3.0), speed: 2.0, fps: 2.0 };
        assert_eq!(Schedule::new(part, 9.0).unwrap().times, [1.0, 2.0, 3.0]);
        for wrong in [
            Course { from: Some(9.5), ..all },
            Course { from: Some(-1.0), ..all },
            Course { to: Some(9.5), ..all },
        ] {
            assert!(matches!(Schedule::new(wrong, 9.0), Err(FilmError::Time { .. })), "{wrong:?}");
        }
        let backwards = Course { from: Some(3.0), to: Some(2.0), ..all };
        assert!(matches!(Schedule::new(backwards, 9.0), Err(FilmError::Backwards { from: 3.0, to: 2.0 })));
        let slow = Course { speed: 1e-6, ..all };
        assert!(matches!(Schedule::new(slow, 9.0), Err(FilmError::Long { .. })));
    }
}
