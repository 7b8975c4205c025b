//! Operations that candle lacks or takes many passes for: the samples about each sample as channels, which turn a convolution
//! into one product of matrices, and bias with activation.

use candle_core::{CpuStorage, CustomOp1, CustomOp2, Layout, Result, Shape, Tensor};

/// Squares of `kernel` × `kernel` samples, of which neighbours lie one sample apart, without padding. Input is
/// (batch, row, column, channel); where `doubled`, each of its samples counts as 2 × 2.
#[derive(Clone, Copy, Debug)]
struct Windows {
    kernel: usize,
    doubled: bool,
}

/// The transposed of [`Windows`]: adds what belongs to each sample of an input of this shape.
#[derive(Clone, Copy, Debug)]
struct Gather {
    windows: Windows,
    input: [usize; 4],
}

/// The `kernel` × `kernel` samples about each sample as channels, without padding.
pub(crate) fn windows(x: &Tensor, kernel: usize, doubled: bool) -> Result<Tensor> {
    x.contiguous()?.apply_op1(Windows { kernel, doubled })
}

impl Windows {
    /// Rows and columns of the result.
    fn size(self, h: usize, w: usize) -> (usize, usize) {
        let scale = 1 + usize::from(self.doubled);
        (scale * h + 1 - self.kernel, scale * w + 1 - self.kernel)
    }

    /// Calls `each(place in the result, place in the input)` for every run of channels of one batch entry.
    fn runs(self, [_, h, w, c]: [usize; 4], mut each: impl FnMut(usize, usize)) {
        let (rows, cols) = self.size(h, w);
        let shift = usize::from(self.doubled);
        let mut to = 0;
        for r in 0..rows {
            for col in 0..cols {
                for y in 0..self.kernel {
                    let line = ((r + y) >> shift) * w;
                    for x in 0..self.kernel {
                        each(to, (line + ((col + x) >> shift)) * c);
                        to += c;
                    }
                }
            }
        }
    }
}

fn values<'a>(storage: &'a CpuStorage, layout: &Layout) -> Result<&'a [f32]> {
    let all = storage.as_slice::<f32>()?;
    match layout.contiguous_offsets() {
        Some((from, to)) => Ok(&all[from..to]),
        None => candle_core::bail!("windows need samples in order"),
    }
}

impl CustomOp1 for Windows {
    fn name(&self) -> &'static str {
        "windows"
    }

    fn cpu_fwd(&self, storage: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let (b, h, w, c) = layout.shape().dims4()?;
        let input = values(storage, layout)?;
        let (rows, cols) = self.size(h, w);
        let size = rows * cols * self.kernel * self.kernel * c;
        let mut out = vec![0.0f32; b * size];
        for (out, input) in out.chunks_exact_mut(size).zip(input.chunks_exact(h * w * c)) {
            self.runs([1, h, w, c], |to, from| out[to..to + c].copy_from_slice(&input[from..from + c]));
        }
        Ok((CpuStorage::F32(out), Shape::from((b, rows, cols, self.kernel * self.kernel * c))))
    }

    fn bwd(&self, arg: &Tensor, _: &Tensor, grad: &Tensor) -> Result<Option<Tensor>> {
        let (b, h, w, c) = arg.dims4()?;
        let gather = Gather { windows: *self, input: [b, h, w, c] };
        Ok(Some(grad.contiguous()?.apply_op1_no_bwd(&gather)?))
    }
}

impl CustomOp1 for Gather {
    fn name(&self) -> &'static str {
        "windows-gather"
    }

    fn cpu_fwd(&self, storage: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let [b, h, w, c] = self.input;
        let grad = values(storage, layout)?;
        let mut out = vec![0.0f32; b * h * w * c];
        for (out, grad) in out.chunks_exact_mut(h * w * c).zip(grad.chunks_exact(grad.len() / b)) {
            self.windows.runs([1, h, w, c], |from, to| {
                for (o, g) in out[to..to + c].iter_mut().zip(&grad[from..from + c]) {
                    *o += g;
                }
            });
        }
        Ok((CpuStorage::F32(out), Shape::from((b, h, w, c))))
    }
}

/// Bias and leaky rectifier in one: leaky(x + bias) of rows.
#[derive(Clone, Copy, Debug)]
struct Activate {
    leak: f32,
}

/// The gradient of [`Activate`] at its input, from its result and the result's gradient.
#[derive(Clone, Copy, Debug)]
struct Slope {
    leak: f32,
}

/// The leaky rectifier of rows plus a bias.
pub(crate) fn activated(x: &Tensor, bias: &Tensor, leak: f32) -> Result<Tensor> {
    x.apply_op2(bias, Activate { leak })
}

impl CustomOp2 for Activate {
    fn name(&self) -> &'static str {
        "activate"
    }

    fn cpu_fwd(&self, x: &CpuStorage, l: &Layout, b: &CpuStorage, m: &Layout) -> Result<(CpuStorage, Shape)> {
        let (x, b) = (values(x, l)?, values(b, m)?);
        let mut out = Vec::with_capacity(x.len());
        for row in x.chunks_exact(b.len()) {
            out.extend(row.iter().zip(b).map(|(x, b)| {
                let v = x + b;
                if v < 0.0 { self.leak * v } else { v }
            }));
        }
        Ok((CpuStorage::F32(out), l.shape().clone()))
    }

    fn bwd(
        &self,
        _: &Tensor,
        _: &Tensor,
        res: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>)> {
        let g = res.detach().apply_op2_no_bwd(&grad.contiguous()?, &Slope { leak: self.leak })?;
        let bias = g.sum(0)?;
        Ok((Some(g), Some(bias)))
    }
}

impl CustomOp2 for Slope {
    fn name(&self) -> &'static str {
        "activate-slope"
    }

    fn cpu_fwd(&self, r: &CpuStorage, l: &Layout, g: &CpuStorage, m: &Layout) -> Result<(CpuStorage, Shape)> {
        let pairs = values(r, l)?.iter().zip(values(g, m)?);
        let out = pairs.map(|(r, g)| if *r < 0.0 { self.leak * g } else { *g }).collect();
        Ok((CpuStorage::F32(out), l.shape().clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use candle_core::{Device, Var};
    use vb_math::rng::Stream;

    fn random(shape: &[usize], seed: u64) -> Var {
        let mut rng = Stream::new(seed, &["ops"]);
        let v: Vec<f32> = (0..shape.iter().product()).map(|_| rng.normal(0.0, 1.0) as f32).collect();
        Var::from_vec(v, shape, &Device::Cpu).unwrap()
    }

    #[test]
    fn windows_hold_the_samples_about_each() {
        let x: Vec<f32> = (0..16).map(|i| i as f32).collect();
        let x = Tensor::from_vec(x, (1, 4, 4, 1), &Device::Cpu).unwrap();
        let w = windows(&x, 3, false).unwrap();
        assert_eq!(w.dims(), [1, 2, 2, 9]);
        let all = w.flatten_all().unwrap().to_vec1::<f32>().unwrap();
        assert_eq!(all[27..], [5.0, 6.0, 7.0, 9.0, 10.0, 11.0, 13.0, 14.0, 15.0]);
        let doubled = windows(&x, 3, true).unwrap();
        assert_eq!(doubled.dims(), [1, 6, 6, 9]);
        let all = doubled.flatten_all().unwrap().to_vec1::<f32>().unwrap();
        assert_eq!(all[..9], [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 4.0, 4.0, 5.0]);
    }

    #[test]
    fn gradients_are_those_of_finite_differences() {
        // A sum with random weights over both operations.
        let (x, bias) = (random(&[2, 4, 5, 3], 1), random(&[27], 2));
        for doubled in [false, true] {
            let f = |x: &Tensor, b: &Tensor| {
                let w = windows(x, 3, doubled).unwrap();
                let (n, h, m, c) = w.dims4().unwrap();
                let y = activated(&w.reshape((n * h * m, c)).unwrap(), b, 0.2).unwrap();
                let weights = random(y.dims(), 3);
                (y * weights.as_tensor()).unwrap().sum_all().unwrap()
            };
            let gradients = f(&x, &bias).backward().unwrap();
            for v in [&x, &bias] {
                let analytic = gradients.get(v).unwrap().flatten_all().unwrap().to_vec1::<f32>().unwrap();
                let values = v.flatten_all().unwrap().to_vec1::<f32>().unwrap();
                for i in [0, 7, values.len() - 1] {
                    let at = |step: f32| {
                        let mut moved = values.clone();
                        moved[i] += step;
                        let moved = Tensor::from_vec(moved, v.shape(), &Device::Cpu).unwrap();
                        let y = if v.elem_count() == 27 { f(&x, &moved) } else { f(&moved, &bias) };
                        y.to_scalar::<f32>().unwrap()
                    };
                    let numeric = (at(1e-3) - at(-1e-3)) / 2e-3;
                    assert!(
                        (numeric - analytic[i]).abs() < 0.03 * analytic[i].abs() + 0.15,
                        "{numeric} {}",
                        analytic[i]
                    );
                }
            }
        }
    }
}
