//! Datasets that somebody else has made.

use std::path::PathBuf;

use vb_dataset::{Dataset, validate};

use crate::site::Site;

/// Two short drives of exploration, without their worlds.
const FILES: [(&str, &[u8]); 5] = [
    ("dataset.json", include_bytes!("../seeds/dataset-v1/dataset.json")),
    ("SHA256SUMS", include_bytes!("../seeds/dataset-v1/SHA256SUMS")),
    ("meta/info.json", include_bytes!("../seeds/dataset-v1/meta/info.json")),
    (
        "meta/episodes/chunk-000/file-000.parquet",
        include_bytes!("../seeds/dataset-v1/meta/episodes/chunk-000/file-000.parquet"),
    ),
    (
        "data/chunk-000/file-000.parquet",
        include_bytes!("../seeds/dataset-v1/data/chunk-000/file-000.parquet"),
    ),
];

fn site() -> Site {
    Site::new().with(FILES.map(|(name, bytes)| (PathBuf::from(name), bytes.to_vec())).to_vec())
}

pub(crate) fn run(data: &[u8]) {
    thread_local!(static SITE: Site = site());
    SITE.with(|site| {
        site.replacing(data, |dir| {
            let _ = validate(dir, &[]);
            let Ok(dataset) = Dataset::open(dir) else { return };
            let frames: usize = dataset.infos().map(|(_, frames)| frames).sum();
            assert_eq!(frames, dataset.frames());
            for episode in dataset.episodes() {
                let Ok(episode) = episode else { return };
                let view = episode.view(dataset.features());
                for frame in 0..episode.frames {
                    let _ = (view.state(frame), view.row("action", frame));
                }
            }
        });
    });
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    site().seeds()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The seed is a dataset of the first layout: it must stay readable.
    #[test]
    fn a_dataset_of_layout_1_is_read() {
        let site = site();
        let dataset = Dataset::open(site.path()).expect("a dataset");
        assert_eq!((dataset.infos().len(), dataset.frames()), (2, 135));
        assert!(dataset.episodes().all(|e| e.is_ok()));
    }
}
