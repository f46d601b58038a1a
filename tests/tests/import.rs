//! Real recordings made by others come in whole, with the mappings kept in `tests/mappings`.
//!
//! The recordings are not part of the project: the folder is `PALPATE_TRACES`, or `../shared/traces`
//! beside the workspace. Where it is missing the tests say so and pass.

use std::path::{Path, PathBuf};

use palpate::trace::{self, Imported, Kind, Mapping, Trace};

/// One recording: mapping, file (or the folder of its files), samples, first and last time, and values of its first and last
/// sample in one column. All numbers were taken from the files by other means.
type Fact = (&'static str, &'static str, usize, [f64; 2], &'static str, [f64; 2]);

const FACTS: &[Fact] = &[
    (
        "oca-shear.toml",
        "oca-shear-cyclic/shear_relaxation.csv",
        590,
        [0.600166, 1142.55],
        "force_N",
        [0.114059, -2.02538],
    ),
    (
        "oca-shear.toml",
        "oca-shear-cyclic/shear_relaxation_1.csv",
        370,
        [1.20017, 1320.15],
        "force_N",
        [0.0491154, 4.34131],
    ),
    (
        "oca-shear.toml",
        "oca-shear-cyclic/shear_relaxation_2.csv",
        370,
        [0.600334, 1020.8],
        "force_N",
        [0.063353, 4.96413],
    ),
    (
        "oca-shear.toml",
        "oca-shear-cyclic/shear_relaxation_5.csv",
        370,
        [0.240333, 841.03],
        "force_N",
        [0.0847339, 5.22134],
    ),
    (
        "rubber-tension.toml",
        "rubber-membrane-24h/rubber_stress_relaxation.csv",
        21661,
        [0.0, 86640.0],
        "force_N",
        [-0.0652619637548923, 3.20676947012544],
    ),
    (
        "creep-compliance.toml",
        "pyrheo-demos/creep_mucus_data.csv",
        20,
        [0.5, 10.0],
        "creep_compliance_per_Pa",
        [0.983779963185571, 2.37242959720201],
    ),
    (
        "creep-compliance.toml",
        "pyrheo-demos/creep_perihepatic_data.csv",
        250,
        [0.01, 3.9810717055349722],
        "creep_compliance_per_Pa",
        [0.02413902559255364, 5.407036390978948],
    ),
    (
        "creep-compliance.toml",
        "pyrheo-demos/creep_ps130_data.csv",
        15257,
        [0.2012, 28800.0],
        "creep_compliance_per_Pa",
        [3.32e-06, 0.00016407323917826087],
    ),
    (
        "creep-compliance.toml",
        "pyrheo-demos/creep_ps160_data.csv",
        3599,
        [0.2011, 3605.0],
        "creep_compliance_per_Pa",
        [9.78e-06, 0.002533423187],
    ),
    (
        "creep-compliance.toml",
        "pyrheo-demos/creep_ps190_data.csv",
        3598,
        [0.2009, 3605.0],
        "creep_compliance_per_Pa",
        [2.61e-05, 0.05367292732],
    ),
    (
        "relaxation-modulus.toml",
        "pyrheo-demos/rel_lapo_3600.csv",
        34,
        [0.28571661633274, 3152.67854550488],
        "relaxation_modulus_Pa",
        [487.824519565457, 272.963440632547],
    ),
    (
        "relaxation-modulus.toml",
        "pyrheo-demos/rel_lapo_600.csv",
        26,
        [0.253494390596655, 755.660469966661],
        "relaxation_modulus_Pa",
        [360.282555869865, 173.219968002962],
    ),
    (
        "relaxation-modulus.toml",
        "pyrheo-demos/stressrelaxation_fishmuscle_data.csv",
        566,
        [0.0139, 981.0],
        "relaxation_modulus_Pa",
        [33600.0, 3190.0],
    ),
    (
        "relaxation-modulus.toml",
        "pyrheo-demos/stressrelaxation_hdpe_data.csv",
        71,
        [0.001, 10000.000000000144],
        "relaxation_modulus_Pa",
        [383502000.0, 140764173.25154996],
    ),
    (
        "relaxation-modulus.toml",
        "pyrheo-demos/stressrelaxation_liquidfoam_data.csv",
        1692,
        [0.40226, 1399.3],
        "relaxation_modulus_Pa",
        [175.18, 4.5452],
    ),
    (
        "relaxation-modulus.toml",
        "pyrheo-demos/stressrelaxation_pp_data.csv",
        76,
        [0.001, 11111.11],
        "relaxation_modulus_Pa",
        [373297000.0, 147432400.0],
    ),
    (
        "relaxation-modulus.toml",
        "pyrheo-demos/stressrelaxation_ps160_data.csv",
        1799,
        [0.2009, 1803.0],
        "relaxation_modulus_Pa",
        [92657.0, 20.21],
    ),
    (
        "hydrogel-rheometer.toml",
        "pyrheo-demos/cnf_hydrogel/HC1_stressrelaxation_20C_10.csv",
        264,
        [0.01, 57.046],
        "relaxation_modulus_Pa",
        [26884.0, 81.042],
    ),
    (
        "hydrogel-rheometer.toml",
        "pyrheo-demos/cnf_hydrogel/HC1_stressrelaxation_20C_11.csv",
        264,
        [0.01, 57.046],
        "relaxation_modulus_Pa",
        [105430.0, 81.778],
    ),
    (
        "hydrogel-rheometer.toml",
        "pyrheo-demos/cnf_hydrogel/HC1_stressrelaxation_20C_12.csv",
        264,
        [0.01, 57.046],
        "relaxation_modulus_Pa",
        [-23703.0, 81.435],
    ),
    (
        "hydrogel-rheometer.toml",
        "pyrheo-demos/cnf_hydrogel/HC1_stressrelaxation_20C_2.csv",
        264,
        [0.01, 57.046],
        "relaxation_modulus_Pa",
        [41761.0, 74.749],
    ),
    (
        "hydrogel-rheometer.toml",
        "pyrheo-demos/cnf_hydrogel/HC1_stressrelaxation_20C_3.csv",
        264,
        [0.01, 57.046],
        "relaxation_modulus_Pa",
        [71940.0, 72.234],
    ),
    (
        "hydrogel-rheometer.toml",
        "pyrheo-demos/cnf_hydrogel/HC1_stressrelaxation_20C_5.csv",
        264,
        [0.01, 57.046],
        "relaxation_modulus_Pa",
        [113470.0, 70.352],
    ),
    (
        "hydrogel-rheometer.toml",
        "pyrheo-demos/cnf_hydrogel/HC1_stressrelaxation_20C_6.csv",
        264,
        [0.01, 57.046],
        "relaxation_modulus_Pa",
        [65432.0, 67.462],
    ),
    (
        "hydrogel-rheometer.toml",
        "pyrheo-demos/cnf_hydrogel/HC1_stressrelaxation_20C_7.csv",
        264,
        [0.01, 57.046],
        "relaxation_modulus_Pa",
        [46270.0, 68.326],
    ),
    (
        "hydrogel-rheometer.toml",
        "pyrheo-demos/cnf_hydrogel/HC1_stressrelaxation_20C_8.csv",
        264,
        [0.01, 57.046],
        "relaxation_modulus_Pa",
        [63415.0, 79.505],
    ),
    (
        "hydrogel-rheometer.toml",
        "pyrheo-demos/cnf_hydrogel/HC1_stressrelaxation_20C_9.csv",
        264,
        [0.01, 57.046],
        "relaxation_modulus_Pa",
        [-52673.0, 80.385],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/BodyDouble SILK.csv",
        258,
        [0.2, 25.9],
        "force_N",
        [0.18558, 20.34774],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/Dragon Skin 10 MEDIUM.csv",
        457,
        [0.2, 45.8000000000001],
        "force_N",
        [0.035784215297491144, 33.18823857992364],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/Dragon Skin 20.csv",
        404,
        [0.2, 40.5],
        "force_N",
        [0.168179994, 79.81604999999999],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/Dragon Skin 30.csv",
        311,
        [0.2, 31.2],
        "force_N",
        [0.31248, 74.61918],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/Dragon Skin FX Pro Slacker.csv",
        798,
        [0.5, 80.2],
        "force_N",
        [0.017493548668405596, 4.859731092277512],
    ),
    (
        "silicone-tension-lost-clock.toml",
        "soro-tensile/Dragon Skin FX Pro.csv",
        724,
        [0.0, 72.3],
        "force_N",
        [0.0016200000000000001, 52.58033999999999],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/Ecoflex 00-10.csv",
        751,
        [0.2, 75.2000000000001],
        "force_N",
        [-0.023399999999999997, 16.6113],
    ),
    (
        "silicone-tension-lost-clock.toml",
        "soro-tensile/Ecoflex 00-30.csv",
        705,
        [0.0, 70.4],
        "force_N",
        [0.02682, 24.470820000000003],
    ),
    (
        "silicone-tension-lost-clock.toml",
        "soro-tensile/Ecoflex 00-35 FAST.csv",
        272,
        [0.0, 27.1],
        "force_N",
        [0.04260000000000006, 11.501819999999999],
    ),
    (
        "silicone-tension-lost-clock.toml",
        "soro-tensile/Ecoflex 00-50.csv",
        721,
        [0.0, 72.0],
        "force_N",
        [-0.01692, 35.6913],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/Mold Star 16 FAST.csv",
        359,
        [0.3, 36.1],
        "force_N",
        [0.123575004, 49.527901314000005],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/Mold Star 20T.csv",
        358,
        [0.2, 35.9],
        "force_N",
        [0.48129003, 58.781517426],
    ),
    (
        "silicone-tension-lost-clock.toml",
        "soro-tensile/PlatSil Gel 10.csv",
        465,
        [0.0, 46.400000000000006],
        "force_N",
        [0.06804, 39.46752],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/Psycho Paint.csv",
        305,
        [0.2, 30.6],
        "force_N",
        [0.47425968, 48.981340728000006],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/RTV615.csv",
        84,
        [0.2, 8.5],
        "force_N",
        [0.6389999999999999, 45.134640000000005],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/Rebound 25.csv",
        275,
        [0.2, 27.6],
        "force_N",
        [0.15035999999999994, 44.784],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/SOLOPLAST 150318.csv",
        325,
        [0.2, 32.6],
        "force_N",
        [0.437323158, 43.054407864],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/SortaClear 40.csv",
        222,
        [0.2, 22.3],
        "force_N",
        [0.5440199999999994, 67.92678],
    ),
    (
        "silicone-tension.toml",
        "soro-tensile/WAGNERSIL 20 NF.csv",
        651,
        [0.0, 13.0],
        "force_N",
        [0.0010000000000000009, 27.043599999999962],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgRelaxedMavaSet_0.1s.csv",
        119,
        [2.0, 301.5005],
        "stress_kPa",
        [0.108133046895888, 6.1073281875562],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgRelaxedMavaSet_100s.csv",
        99,
        [2.0, 161.45],
        "stress_kPa",
        [0.375546360466117, 6.44932899158729],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgRelaxedMavaSet_10s.csv",
        99,
        [2.0, 71.495],
        "stress_kPa",
        [0.279547490798903, 6.38700089589306],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgRelaxedMavaSet_1s.csv",
        99,
        [2.0, 61.501],
        "stress_kPa",
        [0.464524544247957, 6.32412467737992],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgRelaxed_0.1s.csv",
        119,
        [2.0, 301.5005],
        "stress_kPa",
        [0.411311337603269, 6.37145764213913],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgRelaxed_100s.csv",
        99,
        [2.0, 161.45],
        "stress_kPa",
        [0.333319345300858, 6.80694579604455],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgRelaxed_10s.csv",
        99,
        [2.0, 71.495],
        "stress_kPa",
        [0.220405786719571, 6.56874851510509],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgRelaxed_1s.csv",
        99,
        [2.0, 61.501],
        "stress_kPa",
        [-0.214357101699138, 6.97746954681887],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgpCa4.4_0.1s.csv",
        100,
        [2.0, 61.501],
        "stress_kPa",
        [0.365127293570472, 13.0705659725632],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgpCa4.4_100s.csv",
        100,
        [2.0, 161.45],
        "stress_kPa",
        [0.0472259006554241, 13.8751596499818],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgpCa4.4_10s.csv",
        100,
        [2.0, 71.495],
        "stress_kPa",
        [0.0811844492009381, 13.9581116985597],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgpCa4.4_1s.csv",
        100,
        [2.0, 61.501],
        "stress_kPa",
        [0.152364280243182, 14.1178390276286],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgpCa5.5_0.1s.csv",
        60,
        [2.0, 61.501],
        "stress_kPa",
        [-0.37212210288881, 13.3059338548277],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgpCa5.75_0.1s.csv",
        60,
        [2.0, 61.501],
        "stress_kPa",
        [0.22770891916042, 12.3147740672231],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgpCa6.25_0.1s.csv",
        60,
        [2.0, 61.501],
        "stress_kPa",
        [0.534133341439742, 5.73461333389899],
    ),
    (
        "titin-ramp-hold.toml",
        "titin-ramp-hold/AvgpCa6_0.1s.csv",
        60,
        [2.0, 61.501],
        "stress_kPa",
        [0.211848783995604, 6.29034793640956],
    ),
    (
        "afm-force-curve.toml",
        "afm-jpk/afmexperiment-force-save-1.txt",
        408,
        [0.00024414062, 0.19897461],
        "displacement_mm",
        [0.0, 2.1378000000000577e-06],
    ),
    (
        "afm-force-curve.toml",
        "afm-jpk/force-save-JPK-2h.txt",
        1228,
        [0.00024414062, 0.59936523],
        "displacement_mm",
        [0.0, 3.5196999999999385e-06],
    ),
    (
        "tape-tension.toml",
        "vhb4910/0d01_1d5.csv",
        5006,
        [0.0, 100.078],
        "displacement_mm",
        [0.0, -0.0006],
    ),
    (
        "tape-tension.toml",
        "vhb4910/0d01_2d5.csv",
        15006,
        [0.0, 300.072],
        "displacement_mm",
        [0.0, -0.0006],
    ),
    (
        "tape-tension.toml",
        "vhb4910/0d03_1d5_1.csv",
        1675,
        [0.0, 33.428],
        "displacement_mm",
        [0.0, -0.0021],
    ),
    (
        "tape-tension.toml",
        "vhb4910/0d03_1d5_2.csv",
        1678,
        [0.0, 33.484],
        "displacement_mm",
        [0.0, -0.0022],
    ),
    (
        "tape-tension.toml",
        "vhb4910/0d03_2d5.csv",
        5008,
        [0.0, 100.097],
        "displacement_mm",
        [0.0, -0.0009],
    ),
    (
        "tape-tension.toml",
        "vhb4910/0d05_1d5_1.csv",
        1007,
        [0.0, 20.083],
        "displacement_mm",
        [-0.0001, -0.0002],
    ),
    (
        "tape-tension.toml",
        "vhb4910/0d05_2d5_1.csv",
        3012,
        [0.0, 60.168],
        "displacement_mm",
        [0.0, -0.0038],
    ),
    (
        "tape-tension.toml",
        "vhb4910/0d05_2d5_2.csv",
        2012,
        [0.0, 40.165],
        "displacement_mm",
        [0.0, -0.0002],
    ),
    (
        "tape-tension.toml",
        "vhb4910/holds/1d5.csv",
        90104,
        [0.0, 1802.041],
        "displacement_mm",
        [0.0, 40.0],
    ),
    (
        "tape-tension.toml",
        "vhb4910/holds/2d0.csv",
        90204,
        [0.0, 1804.04],
        "displacement_mm",
        [0.0, 80.0],
    ),
    (
        "tape-tension-utf8.toml",
        "vhb4910/holds/3d0.csv",
        36164,
        [0.0, 1808.15],
        "displacement_mm",
        [0.0, 160.0001],
    ),
    (
        "adhesive-pad.toml",
        "ecoflex-adhesive/retract-30-um-s",
        26189,
        [0.5, 1814.9631],
        "force_N",
        [0.005565, 0.004092],
    ),
    (
        "adhesive-pad.toml",
        "ecoflex-adhesive/retract-300-um-s",
        17641,
        [0.5, 738.6121],
        "force_N",
        [-0.005473, -0.008728],
    ),
    (
        "adhesive-pad.toml",
        "ecoflex-adhesive/retract-1000-um-s",
        9499,
        [0.5, 660.1591],
        "force_N",
        [-0.000938, 0.006521],
    ),
    (
        "adhesive-pad.toml",
        "ecoflex-adhesive/retract-3000-um-s",
        5032,
        [0.5, 681.668],
        "force_N",
        [0.002807, -0.004311],
    ),
];

/// The folder of recordings, if there is one.
fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("PALPATE_TRACES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/traces"),
        PathBuf::from,
    );
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: no folder {}; set PALPATE_TRACES to try real recordings", folder.display());
    None
}

fn mapping(name: &str) -> Mapping {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("mappings").join(name);
    Mapping::read(&path).unwrap_or_else(|error| panic!("{error}"))
}

fn import(folder: &Path, mapping_name: &str, file: &str) -> Imported {
    trace::import_parts(&files(&folder.join(file)), &mapping(mapping_name))
        .unwrap_or_else(|error| panic!("{error}"))
}

/// A recording's files: itself, or the tables in its folder in no particular order.
fn files(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.into()];
    }
    let entries = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|it| it == "csv")).collect()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

#[test]
fn every_real_recording_comes_in_with_its_samples_and_values() {
    let Some(folder) = folder() else { return };
    for &(map, file, samples, time, column, values) in FACTS {
        let trace = import(&folder, map, file).trace;
        assert_eq!(trace.len(), samples, "{file}");
        assert!(trace.time.is_sorted_by(|a, b| a < b), "{file}");
        let ends = |all: &[f64]| [all[0], all[all.len() - 1]];
        let found = [ends(&trace.time), ends(trace.column(column).expect(column))];
        for (found, known) in found.as_flattened().iter().zip([time, values].as_flattened()) {
            assert!(close(*found, *known), "{file}: {found} where {known} is known");
        }
    }
}

#[test]
fn an_imported_trace_is_written_and_read_back_as_it_was() {
    let Some(folder) = folder() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("imported.csv");
    for &(map, file, ..) in FACTS {
        let imported = import(&folder, map, file).trace;
        trace::write(&path, &imported).unwrap_or_else(|error| panic!("{file}: {error}"));
        let back = trace::read(&path).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert_eq!(Trace { path: None, ..back }, imported, "{file}");
    }
}

#[test]
fn real_recordings_that_thin_out_have_no_gaps() {
    let Some(folder) = folder() else { return };
    // Of the pads some intervals were not published.
    for &(map, file, ..) in FACTS.iter().filter(|fact| fact.0 != "adhesive-pad.toml") {
        let trace = import(&folder, map, file).trace;
        assert_eq!(trace::gaps(&trace.time), [], "{file}");
    }
}

#[test]
fn holds_of_real_recordings_are_found_where_their_protocol_has_them() {
    let Some(folder) = folder() else { return };
    for (map, file, holds) in [
        ("oca-shear.toml", "oca-shear-cyclic/shear_relaxation_1.csv", 4),
        ("oca-shear.toml", "oca-shear-cyclic/shear_relaxation_2.csv", 4),
        ("oca-shear.toml", "oca-shear-cyclic/shear_relaxation_5.csv", 4),
        ("oca-shear.toml", "oca-shear-cyclic/shear_relaxation.csv", 9),
        ("rubber-tension.toml", "rubber-membrane-24h/rubber_stress_relaxation.csv", 1),
        ("silicone-tension.toml", "soro-tensile/Dragon Skin 30.csv", 0),
    ] {
        let trace = import(&folder, map, file).trace;
        let found = trace::segments(&trace.time, trace.displacement().unwrap());
        let count = found.iter().filter(|segment| segment.kind == Kind::Hold).count();
        assert_eq!(count, holds, "{file}: {found:#?}");
    }
    let rubber =
        import(&folder, "rubber-tension.toml", "rubber-membrane-24h/rubber_stress_relaxation.csv");
    let hold = &trace::holds(&rubber.trace, "force_N").unwrap()[0];
    let (from, to) = (rubber.trace.time[hold.start], rubber.trace.time[hold.end - 1]);
    assert_eq!((from, to), (244.0, 86_640.0), "24 h from the end of the ramp");
}

#[test]
fn a_repeated_time_stamp_and_a_lost_clock_stop_an_import_that_does_not_mention_them() {
    let Some(folder) = folder() else { return };
    let mut map = mapping("rubber-tension.toml");
    map.time.repeated = trace::mapping::Repeated::Error;
    let file = folder.join("rubber-membrane-24h/rubber_stress_relaxation.csv");
    let error = trace::import(&file, &map).unwrap_err().to_string();
    assert!(
        error.contains("line 64, column 1 (Total Time (s)): time 244 s is repeated"),
        "{error}"
    );
    let file = folder.join("soro-tensile/Ecoflex 00-50.csv");
    let error = trace::import(&file, &mapping("silicone-tension.toml")).unwrap_err().to_string();
    assert!(error.contains("line 427, column 1 (Time (s)): time 40.1 s goes backwards"), "{error}");
}

#[test]
fn the_examples_in_the_documentation_are_a_trace_and_a_mapping() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md");
    let docs = std::fs::read_to_string(docs).unwrap();
    let block =
        |kind: &str| docs.split(&format!("```{kind}\n")).nth(1).unwrap().split("```").next();
    let trace = trace::parse(Path::new("docs"), block("text").unwrap().as_bytes()).unwrap();
    assert_eq!(trace.head.specimen.height_mm, Some(30.0));
    let mapping = Mapping::parse(Path::new("docs"), block("toml").unwrap());
    mapping.unwrap_or_else(|error| panic!("{error}"));
}
