//! Files that GDAL writes next to elevation files; expected values follow from what the files state.

use vb_terrain::crs::FOOT;
use vb_terrain::read::{Flaw, Options, Said, survey};

use crate::survey::{Folder, keep, near, read};
use crate::tif::Page;

const GRID: &str = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n0 100 200 300\n";

fn metadata(band: &str) -> String {
    format!(
        "<PAMDataset>\n  <PAMRasterBand band=\"1\">{band}<Metadata><MDI key=\"STATISTICS_MEAN\">5</MDI></Metadata></PAMRasterBand>\
         <PAMRasterBand band=\"2\"><Scale>7</Scale></PAMRasterBand></PAMDataset>\n"
    )
}

fn page() -> Page {
    let raw: Vec<u8> = [0i16, 100, 200, 300].iter().flat_map(|v| v.to_le_bytes()).collect();
    Page::new(2, 2, 16, 2, raw).at([0.0, 2.0], [1.0; 2])
}

#[test]
fn metadata_next_to_a_file_make_heights_of_values() {
    let f = Folder::new();
    let grid = f.file("a.asc", GRID);
    near(read(&grid).heights.values(), &[0.0, 100.0, 200.0, 300.0]);
    let band = "<NoDataValue le_hex_equiv=\"0000000000C07240\">299</NoDataValue><Offset>1000</Offset><Scale>0.1</Scale><UnitType>ft</UnitType>";
    f.file("a.asc.aux.xml", metadata(band));
    let found = read(&grid);
    near(found.heights.values(), &[1000.0 * FOOT, 1010.0 * FOOT, 1020.0 * FOOT, f64::NAN]);
    assert_eq!(found.unit_said, Said::File);
    // What the caller states counts instead.
    let given = survey(&grid, &Options { unit: Some(1.0), no_data: Some(0.0), ..keep() }).unwrap();
    near(&given.heights.values()[..2], &[f64::NAN, 1010.0]);
    // Without exact bytes the digits count, and metadata of another kind say nothing.
    f.file("a.asc.aux.xml", metadata("<NoDataValue>3.0E+02</NoDataValue>"));
    near(read(&grid).heights.values(), &[0.0, 100.0, 200.0, f64::NAN]);
    f.file("a.asc.aux.xml", "<metadata><Esri/></metadata>");
    near(read(&grid).heights.values(), &[0.0, 100.0, 200.0, 300.0]);
}

#[test]
fn metadata_place_files_that_have_no_place_of_their_own() {
    let f = Folder::new();
    let place = "<PAMDataset><SRS dataAxisToSRSAxisMapping=\"1,2\">PROJCS[\"WGS 84 / UTM zone 32N\",GEOGCS[\"WGS 84\",UNIT[\"degree\",0.0174532925199433]],\
                 UNIT[\"metre\",1]]</SRS><GeoTransform> 5.0e+05, 2.0, 0.0, 5.7e+06, 0.0, -2.0</GeoTransform></PAMDataset>";
    let bare = f.file("a.tif", Page::floats(3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).file());
    assert_eq!(read(&bare).heights.resolution(), None);
    f.file("a.tif.aux.xml", place);
    let found = read(&bare);
    assert_eq!(found.heights.resolution(), Some(2.0));
    let at = found.place.unwrap();
    assert_eq!(at.crs.map(|c| c.name), Some("EPSG:32632".into()));
    near(&at.middle, &[500_003.0, 5_699_998.0]);
    // South-up rows are turned.
    f.file("a.tif.aux.xml", place.replace("-2.0", "2.0"));
    near(read(&bare).heights.values(), &[4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
}

#[test]
fn statements_that_contradict_each_other_are_errors() {
    let f = Folder::new();
    let own = "<GDALMetadata><Item name=\"X\" sample=\"0\" role=\"scale\">0.5</Item><Item name=\"X\" sample=\"0\" role=\"unittype\">m</Item></GDALMetadata>";
    let tif = f.file("a.tif", page().text(42112, own).file());
    let told = |band: &str| {
        f.file("a.tif.aux.xml", metadata(band));
        survey(&tif, &keep()).map_err(|e| e.to_string())
    };
    near(
        told("<Scale>0.5</Scale><UnitType>metre</UnitType>").unwrap().heights.values(),
        &[0.0, 50.0, 100.0, 150.0],
    );
    for (band, word) in [
        ("<Scale>0.1</Scale>", "has scale 0.5 and offset 0"),
        ("<UnitType>ft</UnitType>", "heights are in m, but"),
        ("<Scale>x</Scale>", "Scale \"x\""),
        ("<Scale>0</Scale>", "Scale 0"),
        ("<Offset>inf</Offset>", "Offset \"inf\""),
        ("<UnitType>dB</UnitType>", "\"dB\" (UnitType in"),
        ("<NoDataValue>none at all</NoDataValue>", "none at all"),
    ] {
        let e = told(band).unwrap_err();
        assert!(e.contains(word) && !e.contains('\n'), "{band}: {e}");
    }
    f.file("a.tif.aux.xml", "<PAMDataset><GeoTransform>1,2,3</GeoTransform>");
    let e = survey(&tif, &keep()).unwrap_err().to_string();
    assert!(e.contains("aux.xml is not XML") && !e.contains('\n'), "{e}");
}

#[test]
fn a_mask_next_to_a_file_hides_samples() {
    let f = Folder::new();
    let grid = f.file("a.asc", GRID);
    let mask = |cols, values: &[u8]| Page::new(cols, 2, 8, 1, values.to_vec());
    f.file("a.asc.msk", mask(2, &[255, 0, 255, 0]).file());
    let found = read(&grid);
    near(found.heights.values(), &[0.0, f64::NAN, 200.0, f64::NAN]);
    assert!(found.notes.iter().any(|n| n.contains("a.asc.msk")), "{:?}", found.notes);
    assert!(matches!(survey(&grid, &Options::default()).unwrap_err().flaw, Flaw::NoData { count: 2, .. }));
    // Another size can't be a mask of this file, and neither can anything else.
    f.file("a.asc.msk", mask(3, &[255; 6]).file());
    let e = survey(&grid, &keep()).unwrap_err().to_string();
    assert!(e.contains("has 3 x 2 samples, but the heights have 2 x 2"), "{e}");
    f.file("a.asc.msk", "no tiff");
    let e = survey(&grid, &keep()).unwrap_err().to_string();
    assert!(e.contains("its mask") && !e.contains('\n'), "{e}");
}
