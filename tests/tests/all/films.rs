//! Videos and pictures of tasks, as a user makes them.

use std::fs;

use vb_tests::Bench;

use crate::pages::run;

/// Stands in for ffmpeg: keeps its arguments and counts what it reads, and writes the file that it is to write.
#[cfg(unix)]
const FFMPEG: &str = "#!/bin/sh
if [ \"$1\" = -version ]; then exit 0; fi
echo \"$@\" > arguments
for last; do :; done
wc -c | tr -d ' ' > \"${last#file:}\"
";

/// One that has no such encoder.
#[cfg(unix)]
const BROKEN: &str = "#!/bin/sh
if [ \"$1\" = -version ]; then exit 0; fi
echo 'Unknown encoder' >&2
exit 8
";

#[cfg(unix)]
fn program(bench: &Bench, content: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    fs::create_dir_all(bench.path("bin")).expect("a folder");
    bench.write("bin/ffmpeg", content);
    fs::set_permissions(bench.path("bin/ffmpeg"), fs::Permissions::from_mode(0o755)).expect("a program");
}

#[test]
fn runs_are_filmed_beside_each_other_with_the_same_bytes_each_time() {
    let bench = Bench::new();
    run(&bench, "a", "5", "w007/t02");
    run(&bench, "b", "3", "w007/t02");
    let film = |out: &str| {
        let size = ["--size", "240x120", "--fps", "5", "--from", "2", "--to", "4"];
        let args = ["replay", "a", "b", "--task", "w007/t02", "--video", out, "--json"];
        bench.ok(&[&args[..], &size[..]].concat());
        fs::read(bench.path(out)).expect("the video")
    };
    let first = film("1.gif");
    assert!(first == film("2.gif"), "the same runs give the same bytes");
    let again = ["replay", "a", "--task", "w007/t02", "--video", "1.gif"];
    let told = bench.run(&again).error(4);
    assert!(told.contains("1.gif already exists") && told.contains("--force"), "{told}");
    assert_eq!(&first[..6], b"GIF89a");
    assert_eq!(first[6..10], [240, 0, 120, 0], "columns and rows");
    // A loop without an end, and all of it in one file.
    assert!(first.windows(11).any(|w| w == b"NETSCAPE2.0") && first.ends_with(b";"));
    let told = bench.ok(&[
        "replay", "a", "--task", "w007/t02", "--png", "p.png", "--at", "3", "--camera", "map", "--json",
    ]);
    let told: serde_json::Value = serde_json::from_str(&told).expect("a message");
    assert_eq!((&told["png"], &told["page"]), (&"p.png".into(), &serde_json::Value::Null), "no page is made");
    let png = fs::read(bench.path("p.png")).expect("the picture");
    assert_eq!(png[1..4], *b"PNG");
    assert_eq!(png[16..24], [0, 0, 5, 0, 0, 0, 2, 208], "1280 by 720");
}

#[cfg(unix)]
#[test]
fn ffmpeg_gets_every_pixel_and_what_it_says_is_told() {
    let bench = Bench::new();
    run(&bench, "a", "5", "w007/t02");
    let path = bench.path("bin").display().to_string() + ":/usr/bin:/bin";
    let mut args = vec!["replay", "a", "--task", "w007/t02", "--video", "v.mp4", "--size", "160x90"];
    args.extend(["--from", "1", "--to", "2", "--fps", "10", "--speed", "0.5", "--force"]);
    let film = || vb_tests::Done::of(bench.command(&args).env("PATH", &path));
    program(&bench, FFMPEG);
    let done = film();
    // No terminal: a line for each tenth.
    assert!(done.stderr.contains("v.mp4: 21 of 21 frames"), "{}", done.stderr);
    let _ = done.ok();
    // Both ends of a second at half the speed: 21 frames of red, green and blue.
    let bytes = fs::read_to_string(bench.path("v.mp4")).expect("the video");
    assert_eq!(bytes.trim(), (21 * 160 * 90 * 3).to_string());
    let arguments = fs::read_to_string(bench.path("arguments")).expect("what ffmpeg was told");
    for said in ["-video_size 160x90", "-framerate 10", "-c:v libx264", "-f mp4"] {
        assert!(arguments.contains(said), "{said}: {arguments}");
    }
    program(&bench, BROKEN);
    let error = film().error(4);
    assert!(error.contains("v.mp4: ffmpeg failed: Unknown encoder (write a .gif"), "{error}");
    let names = fs::read_dir(bench.path(".")).expect("a folder").map(|e| e.expect("an entry").file_name());
    let half = names.into_iter().any(|name| name.to_string_lossy().ends_with(".tmp"));
    assert!(bench.path("v.mp4").exists() && !half, "the former video stays, and no half of one");
}

#[test]
fn what_cannot_be_filmed_is_said_before_anything_is_drawn() {
    let bench = Bench::new();
    run(&bench, "a", "5", "w007/t02");
    let says = |more: &[&str], wanted: &str| {
        let args = [&["replay", "a", "--task", "w007/t02"], more].concat();
        let error = vb_tests::Done::of(bench.command(&args).env("PATH", bench.path("nothing"))).error(2);
        assert!(error.contains(wanted), "{more:?}: {error}");
    };
    says(&["--video", "v.avi"], "v.avi: unknown video format (use the extension .gif, .mp4 or .webm)");
    says(&["--video", "v.mp4"], "MP4 files need ffmpeg, which is not on the PATH");
    says(
        &["--video", "v.webm", "--size", "101x100"],
        "WebM files need an even width and height, not 101x100",
    );
    says(&["--video", "v.gif", "--fps", "60"], "--fps 60: GIF files support 1 to 50 frames per second");
    says(&["--video", "v.gif", "--from", "500"], "--from 500: the runs cover 0 to ");
    says(&["--png", "p.png", "--at", "500"], "--at 500: the runs cover 0 to ");
    says(&["--camera", "top"], "<--video <FILE>|--png <FILE>>");
    says(
        &["--png", "p.png", "--size", "5000x10"],
        "want columns and rows of 64 to 4096 pixels, e.g. 1280x720",
    );
    says(&["--png", "p.png", "--fps", "10"], "--video <FILE>");
    assert!(!bench.path("v.gif").exists() && !bench.path("p.png").exists());
}
