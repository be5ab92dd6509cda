//! Everything written is read back, and everything that can go wrong is an error that says so.

mod fake;

use std::error::Error;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use mpm_io::{Item, Options, Precision, Results, ResultsError, ResultsWriter, Revolution, Values};
use mpm_solver::observe::{ColumnKind, Counted, Entry, Field, Fields, Observer, Outcome, Space};

type Check = Result<(), Box<dyn Error + Send + Sync>>;

fn write(path: &Path, options: Options, steps: usize, points: usize, outcome: &Outcome) -> Check {
    let mut writer = ResultsWriter::create(path, options)?;
    fake::start(&mut writer, points)?;
    for step in 0..=steps {
        fake::load_step(&mut writer, step, points)?;
    }
    writer.last(0.125 * steps as f64, &fake::Cloud { step: steps, points })?;
    writer.finish(outcome, &fake::timings(steps))
}

#[test]
fn all_numbers_come_back() -> Check {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    for (compression, points) in [(0, 7), (0, 32_769), (1, 7), (9, 131_073), (0, 0)] {
        write(&path, Options { compression, ..fake::options() }, 6, points, &Outcome::Completed)?;
        let results = Results::open(&path)?;
        assert_eq!(results.scene(), fake::options().scene);
        assert_eq!((results.program(), results.status()), ("mpm test", "completed"));

        let mut columns = fake::columns();
        columns.sort_by(|a, b| a.name.cmp(&b.name));
        assert_eq!(results.columns(), columns);
        assert_eq!(results.rows(), 7);
        assert_eq!(results.column("newton_iterations")?.values(), [0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0]);
        let reaction = results.column("reaction/pulled")?;
        assert_eq!((reaction.width(), reaction.len()), (3, 7));
        for step in 0..7 {
            assert_eq!(fake::row(step)[2], Entry::Real(reaction.row(step).to_vec()));
            assert_eq!(results.residuals(step)?, fake::residuals(step));
        }
        let timings = results.timings()?;
        assert_eq!(timings.len(), 2);
        assert_eq!((&*timings[1].phase, timings[1].seconds, timings[1].count), ("solve", 1.5, 6));

        assert_eq!(results.fractions(), [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75]);
        assert_eq!(results.fields()?, ["cauchy_stress", "displacement", "volume"]);
        for step in [0, 3, 6] {
            let cloud = fake::Cloud { step, points };
            assert_eq!(results.points(step)?.values(), cloud.positions());
            for field in fake::fields() {
                let table = results.field(field.name(), step)?;
                assert_eq!((table.width(), table.len()), (field.components(), points));
                assert_eq!(table.values(), cloud.field(field));
            }
        }
    }
    Ok(())
}

#[test]
fn every_dataset_and_attribute_is_listed() -> Check {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    for (precision, kind) in [(Precision::Double, "f64"), (Precision::Single, "f32")] {
        write(&path, Options { precision, compression: 0, ..fake::options() }, 6, 7, &Outcome::Completed)?;
        let items = Results::open(&path)?.contents()?;
        let item = |name: &str| -> &Item {
            items.iter().find(|item| item.name == name).unwrap_or_else(|| panic!("{name} is missing"))
        };
        assert!(items.is_sorted_by(|a, b| a.name < b.name));
        assert_eq!(item("@status").values, Values::Text(vec!["completed".into()]));
        assert_eq!(item("VTKHDF@Type").values, Values::Text(vec!["UnstructuredGrid".into()]));
        assert_eq!(
            item("history@rows"),
            &Item { name: "history@rows".into(), shape: vec![], values: Values::Index(vec![7]) }
        );
        assert_eq!(item("newton/offset").values.kind(), "u64");
        assert_eq!(item("VTKHDF/Types").values.kind(), "u8");
        assert_eq!((&*item("VTKHDF/Points").shape, item("VTKHDF/Points").values.kind()), (&[49, 3][..], "f64"));
        assert_eq!(item("VTKHDF/PointData/cauchy_stress").values.kind(), kind);
        let Values::Text(phases) = &item("timings/phase").values else { panic!("phases are texts") };
        assert_eq!(phases[1], "solve");
        assert!(items.iter().all(|item| item.values.differences(&item.values).is_empty()));
    }
    Ok(())
}

#[test]
fn first_and_last_steps_are_recorded() -> Check {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    let mut writer = ResultsWriter::create(&path, fake::options())?;
    assert!(ResultsWriter::create(&path, fake::options()).is_err());
    fake::start(&mut writer, 5)?;
    drop(writer);
    let results = Results::open(&path)?;
    assert_eq!((results.rows(), results.fractions().len(), results.timings()?.len()), (0, 0, 0));
    assert!(results.column("load_fraction")?.is_empty());
    drop(results);

    let failed = Outcome::Failed("no equilibrium at step 8".into());
    write(&path, Options { every: 3, ..fake::options() }, 7, 5, &failed)?;
    let results = Results::open(&path)?;
    assert_eq!(results.status(), "failed: no equilibrium at step 8");
    assert_eq!(results.fractions(), [0.0, 0.375, 0.75, 0.875]);
    assert_eq!(results.rows(), 8);
    assert_eq!(results.points(3)?.values(), fake::Cloud { step: 7, points: 5 }.positions());
    Ok(())
}

#[test]
fn single_precision_rounds_fields_but_not_positions() -> Check {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    write(&path, Options { precision: Precision::Single, ..fake::options() }, 1, 5, &Outcome::Completed)?;
    let (results, cloud) = (Results::open(&path)?, fake::Cloud { step: 1, points: 5 });
    assert_eq!(results.points(1)?.values(), cloud.positions());
    let rounded: Vec<f64> = cloud.field(Field::VOLUME).iter().map(|&v| f64::from(v as f32)).collect();
    assert_ne!(rounded, cloud.field(Field::VOLUME));
    assert_eq!(results.field("volume", 1)?.values(), rounded);
    Ok(())
}

#[test]
fn histories_longer_than_a_chunk_and_changing_clouds() -> Check {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    for compression in [0, 1] {
        let mut writer = ResultsWriter::create(&path, Options { every: 100, compression, ..fake::options() })?;
        fake::start(&mut writer, 9)?;
        for step in 0..1100 {
            fake::load_step(&mut writer, step, 9 + step / 300)?;
        }
        // Readable before the end, too: the file is complete after every step.
        drop(writer);
        let results = Results::open(&path)?;
        assert_eq!((results.status(), results.rows()), ("running", 1100));
        assert_eq!(results.column("load_fraction")?.row(1099), [0.125 * 1099.0]);
        assert_eq!(results.residuals(1099)?, fake::residuals(1099));
        for (k, step) in (0..1100).step_by(100).enumerate() {
            assert_eq!(results.points(k)?.values(), fake::Cloud { step, points: 9 + step / 300 }.positions());
        }
    }
    Ok(())
}

#[test]
fn unwritable_paths_are_refused_and_keep_what_is_there() -> Check {
    let directory = tempfile::tempdir()?;
    let create = |path: &Path| match ResultsWriter::create(path, fake::options()) {
        Ok(_) => panic!("{} was created", path.display()),
        Err(error) => {
            assert!(matches!(error, ResultsError::Create { .. }), "{error:?}");
            let text = error.to_string();
            assert!(text.contains(&*path.to_string_lossy()), "{text}");
            text
        }
    };
    assert!(create(directory.path()).contains("is a directory"));
    assert!(create(&directory.path().join("missing/run.h5")).contains("there is no directory"));
    assert!(create(&directory.path().join("run.xdmf")).contains("choose another ending"));
    assert!(
        create(Path::new("/proc/run.h5")).contains("No such file"),
        "{}",
        create(Path::new("/proc/run.h5"))
    );

    let running = directory.path().join("running.h5");
    let mut writer = ResultsWriter::create(&running, fake::options())?;
    fake::start(&mut writer, 3)?;
    fake::load_step(&mut writer, 0, 3)?;
    assert!(create(&running).contains("another program has the file open"));
    drop(writer);
    assert_eq!(Results::open(&running)?.rows(), 1);

    let nul = Options { scene: "a\0b".into(), ..Options::default() };
    assert!(matches!(ResultsWriter::create(&running, nul), Err(ResultsError::Create { .. })));
    let level = Options { compression: 10, ..Options::default() };
    assert!(matches!(ResultsWriter::create(&running, level), Err(ResultsError::Create { .. })));
    assert_eq!(Results::open(&running)?.rows(), 1, "a refused run has destroyed results");

    // Root may write anywhere; then there is nothing to see here.
    let locked = directory.path().join("locked");
    fs::create_dir(&locked)?;
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o555))?;
    if fs::write(locked.join("probe"), "").is_err() {
        assert!(create(&locked.join("run.h5")).contains("Permission denied"));
    }
    Ok(())
}

#[test]
fn a_column_that_cannot_be_stored_is_an_error() -> Check {
    use mpm_solver::observe::{Column, RunStart};
    let directory = tempfile::tempdir()?;
    let mut writer = ResultsWriter::create(directory.path().join("run.h5"), Options::default())?;
    let column = Column { name: "twice".into(), kind: ColumnKind::Real, width: 1 };
    let error = writer.start(&RunStart {
        space: Space::Cartesian,
        columns: vec![column.clone(), column],
        points: 1,
        steps: 1,
        stages: 1,
        counted: Counted::Rows,
    });
    assert!(error.is_err_and(|error| error.to_string().contains("cannot write the layout of the run")));
    Ok(())
}

/// Set for the process that meets the full disk; its value is the path.
const FULL: &str = "MPM_IO_FULL_DISK";

#[test]
fn a_full_disk_is_an_error_and_keeps_earlier_steps() -> Check {
    if let Ok(path) = std::env::var(FULL) {
        // Exit codes tell the parent what happened; a panic would give 101.
        let path = Path::new(&path);
        let options = Options { keep_back: Duration::ZERO, ..fake::options() };
        let mut writer = ResultsWriter::create(path, options)?;
        fake::start(&mut writer, 1000)?;
        let mut written = 0;
        let error = loop {
            match fake::load_step(&mut writer, written, 1000) {
                Ok(()) => written += 1,
                Err(error) => break error,
            }
        };
        assert!(matches!(error.downcast_ref(), Some(ResultsError::Write { .. })), "{error:?}");
        let text = error.to_string();
        assert!(text.contains(&format!("load step {written}")) && text.contains("File too large"), "{text}");
        let _ = writer.finish(&Outcome::Failed("the disk is full".into()), &[]);
        drop(writer);
        assert!(written > 3, "{written} steps");
        std::io::Write::write_all(&mut std::io::stderr(), format!("written {written};").as_bytes())?;
        return Ok(());
    }
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    // A limit on the size of files fails as a full disk does, without one.
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 40000; exec \"$@\"", "sh"])
        .arg(std::env::current_exe()?)
        .args(["--exact", "a_full_disk_is_an_error_and_keeps_earlier_steps", "--nocapture"])
        .env(FULL, &path)
        .output()?;
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{:?}: {said}", output.status);
    let written: usize = said.trim_start_matches("written ").trim_end_matches(';').parse()?;
    let results = Results::open(&path)?;
    // Rows of the batch that did not fit are lost.
    let most_lost = (8 << 20) / (1000 * 8 * 3);
    let rows = results.rows();
    assert!(rows > 20 && rows + most_lost >= written, "{rows} rows of {written}");
    for k in 0..rows {
        assert_eq!(results.points(k)?.values(), fake::Cloud { step: k, points: 1000 }.positions());
    }
    Ok(())
}

#[test]
fn what_is_no_results_file_is_refused() -> Check {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    assert!(matches!(Results::open(&path), Err(ResultsError::Open { .. })));
    fs::write(&path, "not HDF5")?;
    assert!(matches!(Results::open(&path), Err(ResultsError::Open { .. })));
    hdf5::File::create(&path)?.close()?;
    assert!(matches!(Results::open(&path), Err(ResultsError::Malformed { .. })));

    write(&path, fake::options(), 2, 4, &Outcome::Completed)?;
    let results = Results::open(&path)?;
    assert!(matches!(results.column("nothing"), Err(ResultsError::Missing { .. })));
    assert!(matches!(results.residuals(3), Err(ResultsError::Missing { .. })));
    assert!(matches!(results.points(3), Err(ResultsError::Missing { .. })));
    assert!(matches!(results.field("nothing", 0), Err(ResultsError::Missing { .. })));
    drop(results);

    let file = hdf5::File::open_rw(&path)?;
    file.dataset("VTKHDF/Points")?.resize((usize::MAX >> 8, 3))?;
    file.dataset("VTKHDF/Steps/PointDataOffsets/volume")?.write_slice(&[-1_i64], 0..1)?;
    file.close()?;
    let results = Results::open(&path)?;
    assert!(matches!(results.points(0), Err(ResultsError::Malformed { .. })));
    assert!(matches!(results.field("volume", 0), Err(ResultsError::Malformed { .. })));
    drop(results);

    let file = hdf5::File::open_rw(&path)?;
    file.attr("version")?.write_scalar(&2_i64)?;
    file.close()?;
    assert!(Results::open(&path).is_err_and(|error| error.to_string().contains("is 2; this program reads 1")));
    // How the run ended may not have reached a full disk; all else is there.
    write(&path, fake::options(), 2, 4, &Outcome::Completed)?;
    let file = hdf5::File::open_rw(&path)?;
    file.delete_attr("status")?;
    file.close()?;
    let results = Results::open(&path)?;
    assert_eq!((results.status(), results.rows()), ("running", 3));
    Ok(())
}

#[test]
fn results_of_bodies_of_revolution_say_r_and_z() -> Check {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("run.h5");
    for (space, head, unit) in [
        (
            Space::Axisymmetric,
            "r,z,t,cauchy_stress.rr,cauchy_stress.rz,cauchy_stress.rt,cauchy_stress.zr",
            "L³",
        ),
        (Space::Cartesian, "x,y,z,cauchy_stress.xx,cauchy_stress.xy,cauchy_stress.xz,cauchy_stress.yx", "L^D"),
    ] {
        let mut writer = ResultsWriter::create(&path, fake::options())?;
        fake::start_in(space, &mut writer, 3)?;
        fake::load_step(&mut writer, 0, 3)?;
        writer.finish(&Outcome::Completed, &fake::timings(0))?;
        let results = Results::open(&path)?;
        assert_eq!((results.space(), results.unit("volume")?.as_str()), (space, unit));
        let written = results.write_csv(&directory.path().join("csv"))?;
        assert!(fs::read_to_string(&written[1])?.starts_with(head));
        let column = format!("reaction/pulled.{}", &head[2..3]);
        assert!(fs::read_to_string(&written[0])?.lines().next().is_some_and(|line| line.contains(&column)));
        // No outlines, or no body of revolution.
        let refused = results.write_revolved(directory.path(), Revolution::new(3, 360.0)?);
        assert!(matches!(refused, Err(ResultsError::Missing { .. })));
    }
    Ok(())
}
