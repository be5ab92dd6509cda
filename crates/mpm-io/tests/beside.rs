//! Points that a thread writes while the run goes on, and fields of which a part is stored.

mod fake;

use mpm_io::{Components, Options, Precision, Results, ResultsError, ResultsWriter};
use mpm_solver::observe::{Field, Observer, ObserverError, Outcome};
use std::path::Path;
use std::process::Command;

type Check = Result<(), ObserverError>;

/// Points whose fields take more than what is written at once.
const MANY: usize = 20_000;

fn write(path: &Path, options: Options, steps: usize) -> Check {
    let mut writer = ResultsWriter::create(path, options)?;
    fake::start(&mut writer, MANY)?;
    for step in 0..steps {
        fake::load_step(&mut writer, step, MANY)?;
    }
    writer.finish(&Outcome::Completed, &fake::timings(steps))?;
    Ok(())
}

#[test]
fn a_thread_writes_what_is_written_without_one() -> Check {
    let directory = tempfile::tempdir()?;
    let paths = ["with.h5", "without.h5"].map(|name| directory.path().join(name));
    for (path, beside) in paths.iter().zip([true, false]) {
        write(path, Options { beside, ..fake::options() }, 12)?;
    }
    let [with, without] = [Results::open(&paths[0])?, Results::open(&paths[1])?];
    assert_eq!(with.fractions().len(), 12);
    assert_eq!(with.contents()?, without.contents()?);
    // The grids of the XDMF file, too; it names the results file.
    let text = |path: &Path, name: &str| {
        std::fs::read_to_string(path.with_extension("xdmf")).map(|text| text.replace(name, ""))
    };
    assert_eq!(text(&paths[0], "with.h5")?, text(&paths[1], "without.h5")?);
    Ok(())
}

#[test]
fn flushing_waits_for_the_thread() -> Check {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    let mut writer = ResultsWriter::create(&path, Options { beside: true, ..fake::options() })?;
    fake::start(&mut writer, MANY)?;
    for step in 0..5 {
        fake::load_step(&mut writer, step, MANY)?;
        writer.flush()?;
        writer.sync()?;
        assert_eq!(Results::open(&path)?.rows(), step + 1);
    }
    Ok(())
}

/// Set for the process that meets the full disk; its value is the path.
const FULL: &str = "MPM_IO_FULL_DISK_BESIDE";

#[test]
fn a_disk_that_a_thread_finds_full_ends_the_run() -> Check {
    if let Ok(path) = std::env::var(FULL) {
        let mut writer = ResultsWriter::create(Path::new(&path), Options { beside: true, ..fake::options() })?;
        fake::start(&mut writer, MANY)?;
        let failed = (0..100).find_map(|step| fake::load_step(&mut writer, step, MANY).err());
        let error = failed.ok_or("no step fails")?;
        assert!(matches!(error.downcast_ref(), Some(ResultsError::Write { .. })), "{error:?}");
        assert!(error.to_string().contains("File too large"), "{error}");
        // It is told once.
        writer.finish(&Outcome::Failed("the disk is full".into()), &[])?;
        return Ok(());
    }
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 80000; exec \"$@\"", "sh"])
        .arg(std::env::current_exe()?)
        .args(["--exact", "a_disk_that_a_thread_finds_full_ends_the_run", "--nocapture"])
        .env(FULL, &path)
        .output()?;
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // 40 MB hold some ten steps of 2.5 MB; two batches of 4 MB may be lost.
    let results = Results::open(&path)?;
    assert!(results.rows() > 6, "{} rows", results.rows());
    let last = results.fractions().len() - 1;
    assert_eq!(results.field("volume", last)?.row(7)[0], fake::value(7, last, 7, 0));
    Ok(())
}

#[test]
fn fields_in_the_plane_are_read_with_all_components() -> Check {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    let fields = vec![Field::DISPLACEMENT, Field::DEFORMATION_GRADIENT, Field::CAUCHY_STRESS, Field::VOLUME];
    let options = |precision| Options {
        fields: fields.clone(),
        components: Components::InPlane,
        precision,
        ..fake::options()
    };
    write(&path, options(Precision::Double), 2)?;
    let results = Results::open(&path)?;
    let expected = |field: Field, places: &[(usize, usize)]| {
        let mut row = vec![0.0; field.components()];
        for &(place, of) in places {
            row[place] = fake::value(1 + field.name().len(), 1, 5, of);
        }
        row
    };
    let cases = [
        (Field::DISPLACEMENT, &[(0, 0), (1, 1)][..]),
        (Field::DEFORMATION_GRADIENT, &[(0, 0), (1, 1), (3, 3), (4, 4), (8, 8)]),
        // Stored once, xy is read twice.
        (Field::CAUCHY_STRESS, &[(0, 0), (1, 1), (3, 1), (4, 4), (8, 8)]),
        (Field::VOLUME, &[(0, 0)]),
    ];
    for (field, places) in cases {
        assert_eq!(results.field(field.name(), 1)?.row(5), expected(field, places), "{}", field.name());
    }
    let shapes: Vec<(String, Vec<usize>)> =
        results.contents()?.into_iter().map(|item| (item.name, item.shape)).collect();
    let width = |name: &str| shapes.iter().find(|(it, _)| it == name).map(|(_, shape)| shape.clone());
    assert_eq!(width("VTKHDF/PointData/cauchy_stress"), Some(vec![2 * MANY, 4]));
    assert_eq!(width("VTKHDF/PointData/deformation_gradient"), Some(vec![2 * MANY, 5]));
    assert_eq!(width("VTKHDF/PointData/displacement"), Some(vec![2 * MANY, 2]));

    let whole = std::fs::metadata(&path)?.len();
    drop(results);
    write(&path, options(Precision::Single), 2)?;
    assert!(std::fs::metadata(&path)?.len() < whole * 3 / 4);
    let results = Results::open(&path)?;
    let rounded: Vec<f64> =
        expected(Field::CAUCHY_STRESS, cases[2].1).iter().map(|&x| f64::from(x as f32)).collect();
    assert_eq!(results.field("cauchy_stress", 1)?.row(5), rounded);
    Ok(())
}
