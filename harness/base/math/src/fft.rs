//! A two-dimensional inverse Fourier transform whose bits depend on nothing but its input: libraries choose their
//! instructions by processor.

use std::f64::consts::TAU;

/// A complex number: real and imaginary part.
pub type Complex = [f64; 2];

fn multiply(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// Inverse transform in place without normalisation, x_j = Σ_k X_k exp(2πi jk/n), of a power-of-two length
/// (Cooley and Tukey 1965, radix 2). `roots[k]` is exp(2πi k/n) for k < n/2.
fn transform(x: &mut [Complex], roots: &[Complex]) {
    let n = x.len();
    let bits = n.trailing_zeros();
    for i in 0..n {
        let j = i.reverse_bits() >> (usize::BITS - bits);
        if i < j {
            x.swap(i, j);
        }
    }
    let mut half = 1;
    while half < n {
        let stride = n / (2 * half);
        for block in x.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let t = multiply(roots[k * stride], *b);
                *b = [a[0] - t[0], a[1] - t[1]];
                *a = [a[0] + t[0], a[1] + t[1]];
            }
        }
        half *= 2;
    }
}

/// Inverse transform of an n × n spectrum (row-major) in place, without normalisation:
/// x_ij = Σ_kl X_kl exp(2πi (ik + jl)/n). The forward transform of real values is the conjugate of this.
///
/// # Panics
/// If n is no power of two from 2, or there are not n² values.
pub fn inverse_2d(spectrum: &mut [Complex], n: usize) {
    assert!(n.is_power_of_two() && n >= 2 && spectrum.len() == n * n);
    let roots: Vec<Complex> = (0..n / 2)
        .map(|k| {
            let (s, c) = crate::sin_cos(TAU * k as f64 / n as f64);
            [c, s]
        })
        .collect();
    for row in spectrum.chunks_exact_mut(n) {
        transform(row, &roots);
    }
    let mut column = vec![[0.0; 2]; n];
    for c in 0..n {
        for (r, v) in column.iter_mut().enumerate() {
            *v = spectrum[r * n + c];
        }
        transform(&mut column, &roots);
        for (r, v) in column.iter().enumerate() {
            spectrum[r * n + c] = *v;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_sum_that_defines_the_transform() {
        let n = 8;
        let mut rng = crate::rng::Stream::new(1, &["fft"]);
        let spectrum: Vec<Complex> =
            (0..n * n).map(|_| [rng.normal(0.0, 1.0), rng.normal(0.0, 1.0)]).collect();
        let mut fast = spectrum.clone();
        inverse_2d(&mut fast, n);
        for (i, got) in fast.iter().enumerate() {
            let (y, x) = (i / n, i % n);
            let mut sum = [0.0; 2];
            for (k, &value) in spectrum.iter().enumerate() {
                let (s, c) = crate::sin_cos(TAU * ((k / n * y + k % n * x) % n) as f64 / n as f64);
                let term = multiply(value, [c, s]);
                sum = [sum[0] + term[0], sum[1] + term[1]];
            }
            assert!(
                (got[0] - sum[0]).abs() < 1e-12 && (got[1] - sum[1]).abs() < 1e-12,
                "{i}: {got:?} {sum:?}"
            );
        }
    }
}
