//! What drawing a surface costs.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use vb_terrain::{Model, Request};

fn surfaces(c: &mut Criterion) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks/terrain/rocks.safetensors");
    let model = Model::read(&path).expect("the shipped model");
    for nodes in [129, 513] {
        let request = Request { seed: 1, rows: nodes, cols: nodes, resolution: 1.0, fraction: 1.0 };
        c.bench_function(&format!("surface of {nodes} x {nodes} nodes, 1 m apart"), |b| {
            b.iter(|| model.surface(black_box(&request)).expect("a surface"));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = surfaces
}
criterion_main!(benches);
