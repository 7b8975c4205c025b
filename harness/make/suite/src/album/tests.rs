//! The page as text: what it holds, and that nothing in it comes alive.

use super::Album;
use crate::statistics::{SuiteStatistics, Survey};
use vb_world::{Provenance, Suite, SuiteMeta};

fn page(suite: &Suite) -> String {
    let mut survey = Survey::default();
    let mut album = Album::new(suite.worlds().len());
    for info in suite.worlds() {
        let world = suite.load_world(&info.id).unwrap();
        album.add(&world, survey.add(&world));
    }
    let statistics: SuiteStatistics = survey.finish(suite, None);
    album.page(&statistics)
}

fn built_in() -> Suite {
    Suite::open(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tasks/smoke")).unwrap()
}

fn write(meta: &SuiteMeta) -> (tempfile::TempDir, Suite) {
    let dir = tempfile::tempdir().unwrap();
    let suite = Suite::write(dir.path(), meta, &[built_in().load_world("w001").unwrap()]).unwrap();
    (dir, suite)
}

#[test]
fn a_page_shows_every_obstacle_path_start_and_goal_of_a_world() {
    let (_dir, suite) = write(built_in().meta());
    let world = suite.load_world("w001").unwrap();
    let page = page(&suite);
    let count = |text: &str| page.matches(text).count();
    // The legend shows a path, a start and a goal too.
    assert_eq!(count("class=\"start\""), world.tasks.len() + 1);
    assert_eq!(count("class=\"goal\""), world.tasks.len() + 1);
    assert_eq!(count("class=\"line\""), world.tasks.len() + 1);
    let drawn: usize = page
        .split("<g class=\"obstacles\">")
        .skip(1)
        .map(|g| g.split("</g>").next().unwrap_or("").matches('Z').count())
        .sum();
    assert_eq!(drawn, world.obstacles.len());
    for layer in ["shade", "layer classes", "layer heights", "layer slopes", "layer friction"] {
        assert_eq!(count(&format!("<image class=\"{layer}\"")), 1, "{layer}");
    }
    assert!(page.contains(&suite.hash()[..16]) && page.contains("seed 2025"));
}

#[test]
fn a_page_needs_no_other_file_and_no_network() {
    let (_dir, suite) = write(built_in().meta());
    let page = page(&suite);
    for part in ["src=\"", "@import", "url(", "http://", "https://", "<link"] {
        assert!(!page.contains(part), "{part}");
    }
    assert!(
        page.split("href=\"").skip(1).all(|h| h.starts_with("data:image/png;base64,") || h.starts_with('#'))
    );
    assert!(page.contains("default-src 'none'"));
}

#[test]
fn hostile_names_are_shown_as_text() {
    let evil = "\"><script>alert('x')</script><img src=x onerror=alert(1)>' onload='x";
    let (_dir, suite) = write(&SuiteMeta {
        name: evil.into(),
        version: evil.into(),
        description: format!("{evil}</style></title>"),
        provenance: Provenance::Authored { by: evil.into() },
    });
    let page = page(&suite);
    assert!(!page.contains("<script>alert") && !page.contains("<img") && !page.contains("onload='x"));
    assert_eq!(page.matches("<script").count(), 1, "the page's own");
    assert_eq!((page.matches("</title>").count(), page.matches("</style>").count()), (1, 1));
    assert!(page.contains("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;"));
}

#[test]
fn pictures_of_many_worlds_are_smaller_so_that_the_page_stays_small() {
    assert_eq!(Album::new(1).side, 384);
    // 100 worlds of 256 x 256 pixels, a byte each at most, and a third more as text, are below 9 MB.
    assert_eq!(Album::new(100).side, 256);
    assert_eq!(Album::new(999).side, 96);
}
