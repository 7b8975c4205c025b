//! Random processes, each drawn from a stream of its own.
//!
//! A stream is named by the run's seed, the task, the sensor and the part of the sensor, so the presence of one sensor
//! changes no other's numbers. Processes move on with every sample of a trial (10 ms), however often anybody reads them.

use vb_math::rng::Stream;

/// What names the streams of a trial: the run's seed and the full name of the task, e.g. `w001/t03`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seed {
    pub run: u64,
    /// The full name of the task.
    pub task: String,
}

impl Seed {
    /// The stream of a part of a sensor.
    #[must_use]
    pub fn stream(&self, sensor: &str, part: &str) -> Stream {
        Stream::new(self.run, &["sense", &self.task, sensor, part])
    }
}

/// The number below which a standard normal variable lies with the probability `p`, in (0, 1): Wichura, "Algorithm AS 241:
/// The percentage points of the normal distribution", Applied Statistics 37 (1988), PPND7, right to seven digits. One
/// uniform number gives one normal, mostly without a logarithm, which a scan of thousands of beams is faster by.
#[must_use]
pub fn normal_quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180_625 - q * q;
        let above = ((59.109_374_72 * r + 159.291_132_02) * r + 50.434_271_938) * r + 3.387_132_717_9;
        let below = ((67.187_563_6 * r + 78.757_757_664) * r + 17.895_169_469) * r + 1.0;
        return q * above / below;
    }
    let tail = if q < 0.0 { p } else { 1.0 - p };
    let r = (-vb_math::ln(tail)).sqrt();
    let size = if r <= 5.0 {
        let r = r - 1.6;
        let above = ((0.170_238_211_03 * r + 1.306_728_481_6) * r + 2.756_815_39) * r + 1.423_437_277_7;
        above / ((0.120_211_329_75 * r + 0.737_001_642_5) * r + 1.0)
    } else {
        let r = r - 5.0;
        let above = ((0.017_337_203_997 * r + 0.428_682_943_37) * r + 3.081_226_386) * r + 6.657_905_115;
        above / ((0.012_258_202_635 * r + 0.241_978_942_25) * r + 1.0)
    };
    if q < 0.0 { -size } else { size }
}

/// A uniform number in (0, 1) and a standard normal one, from one draw of 64 bits: the two halves of it.
pub(crate) fn uniform_and_normal(stream: &mut Stream) -> (f64, f64) {
    let bits = stream.next_u64();
    let unit = |half: u32| (f64::from(half) + 0.5) * (1.0 / 4_294_967_296.0);
    (unit((bits >> 32) as u32), normal_quantile(unit(bits as u32)))
}

/// White noise: independent normal numbers of mean 0.
#[derive(Clone, Debug)]
pub struct White {
    std: f64,
    stream: Stream,
}

impl White {
    /// Noise with a standard deviation, in the unit of what it is added to.
    #[must_use]
    pub fn new(std: f64, stream: Stream) -> Self {
        Self { std, stream }
    }

    /// The next number.
    pub fn step(&mut self) -> f64 {
        self.std * normal(&mut self.stream)
    }
}

fn normal(stream: &mut Stream) -> f64 {
    stream.normal(0.0, 1.0)
}

/// A first-order Gauss–Markov process, discretised exactly: x' = a·x + σ·√(1 − a²)·n with a = exp(−dt/T), whose values are
/// normal with the standard deviation σ and correlated by exp(−|τ|/T) at every distance τ (Gelb, "Applied Optimal
/// Estimation", 1974, section 2.2).
#[derive(Clone, Debug)]
pub struct GaussMarkov {
    keep: f64,
    fresh: f64,
    value: f64,
    stream: Stream,
}

impl GaussMarkov {
    /// A process with the standard deviation `std` and the correlation time `correlation`, s, in steps of `dt`, s. It begins
    /// as if it had always been running.
    #[must_use]
    pub fn new(std: f64, correlation: f64, dt: f64, mut stream: Stream) -> Self {
        let keep = vb_math::exp(-dt / correlation);
        let value = std * normal(&mut stream);
        Self { keep, fresh: std * (1.0 - keep * keep).sqrt(), value, stream }
    }

    #[must_use]
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Moves on by one step and gives the value there.
    pub fn step(&mut self) -> f64 {
        self.value = self.keep * self.value + self.fresh * normal(&mut self.stream);
        self.value
    }
}

/// A random walk: a sum of independent normal steps whose variance grows with the way that is walked.
#[derive(Clone, Debug)]
pub struct RandomWalk {
    rate: f64,
    value: f64,
    stream: Stream,
}

impl RandomWalk {
    /// A walk that begins at `start` and has the standard deviation `rate`·√s after a way s, which is a time in s or a
    /// distance in m.
    #[must_use]
    pub fn new(rate: f64, start: f64, stream: Stream) -> Self {
        Self { rate, value: start, stream }
    }

    #[must_use]
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Moves on by `way` and gives the value there.
    pub fn step(&mut self, way: f64) -> f64 {
        self.value += self.rate * way.sqrt() * normal(&mut self.stream);
        self.value
    }
}

/// A process of two states, up and out, with exponential times in both, discretised exactly: the probabilities of a change
/// within a step are those of the Markov chain in continuous time. It begins up.
#[derive(Clone, Debug)]
pub struct Outage {
    to_out: f64,
    to_up: f64,
    out: bool,
    stream: Stream,
}

impl Outage {
    /// A process that is up for `interval` and out for `duration` in the mean, both in s, in steps of `dt`, s.
    #[must_use]
    pub fn new(interval: f64, duration: f64, dt: f64, stream: Stream) -> Self {
        let (leave, back) = (1.0 / interval, 1.0 / duration);
        let all = leave + back;
        let changed = 1.0 - vb_math::exp(-all * dt);
        Self { to_out: leave / all * changed, to_up: back / all * changed, out: false, stream }
    }

    #[must_use]
    pub fn is_out(&self) -> bool {
        self.out
    }

    /// Moves on by one step and tells whether it is out then.
    pub fn step(&mut self) -> bool {
        let u = self.stream.unit();
        self.out = if self.out { u >= self.to_up } else { u < self.to_out };
        self.out
    }
}
