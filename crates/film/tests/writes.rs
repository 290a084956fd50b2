//! Files that appear only when they are whole.

use reflet_film::{Format, PendingFolders, SafeFile, Target, stray_files};
use std::ffi::OsStr;
use std::fs;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

fn write(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = SafeFile::create(path)?;
    file.write_all(bytes)?;
    file.commit()
}

/// The names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_file_appears_when_it_is_committed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep/er/a.png");
    let mut file = SafeFile::create(&path).unwrap();
    file.write_all(b"half").unwrap();
    assert!(!path.exists());
    let strays = stray_files(path.parent().unwrap()).unwrap();
    assert_eq!(strays.len(), 1);
    assert!(strays[0].is_ours() && !strays[0].remove_orphan().unwrap());
    file.write_all(b" and half").unwrap();
    file.commit().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"half and half");
    assert_eq!(names(path.parent().unwrap()), ["a.png"]);

    // Over an old one, with the folder synced later.
    let mut folders = PendingFolders::new();
    let mut file = SafeFile::create(&path).unwrap();
    file.write_all(b"new").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"half and half");
    file.commit_in(&mut folders).unwrap();
    folders.sync().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert_eq!(names(path.parent().unwrap()), ["a.png"]);
}

#[test]
fn a_file_that_is_dropped_leaves_no_trace() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    for before in [None, Some(b"old")] {
        if let Some(bytes) = before {
            fs::write(&path, bytes).unwrap();
        }
        let mut file = SafeFile::create(&path).unwrap();
        file.write_all(b"half").unwrap();
        drop(file);
        assert_eq!(fs::read(&path).ok().as_deref(), before.map(|b| &b[..]));
        assert!(stray_files(folder.path()).unwrap().is_empty());
    }
}

#[test]
fn two_writers_of_one_name_do_not_mix() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let mut first = SafeFile::create(&path).unwrap();
    let mut second = SafeFile::create(&path).unwrap();
    first.write_all(b"first").unwrap();
    second.write_all(b"second").unwrap();
    second.commit().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"second");
    first.commit().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"first");
    assert_eq!(names(folder.path()), ["a.png"]);
}

#[test]
fn a_copy_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("a"), folder.path().join("b"));
    fs::write(&from, vec![7; 100_000]).unwrap();
    let mut file = SafeFile::create(&to).unwrap();
    assert_eq!(file.copy_from(&from).unwrap(), 100_000);
    file.commit().unwrap();
    assert_eq!(fs::read(&to).unwrap(), fs::read(&from).unwrap());
    let mut file = SafeFile::create(&to).unwrap();
    let error = file.copy_from(&folder.path().join("none")).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::NotFound);
}

#[test]
fn errors_name_the_path_and_say_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let text = |path: &Path| SafeFile::create(path).unwrap_err().to_string();

    let error = text(folder.path());
    assert!(error.ends_with("it is a folder; name a file in it"), "{error}");

    fs::write(at("file"), b"x").unwrap();
    let error = text(&at("file/a.png"));
    assert!(error.contains("file") && error.contains("cannot make the folder"), "{error}");
    assert_eq!(fs::read(at("file")).unwrap(), b"x");

    let error = text(&at("none/.."));
    assert!(error.ends_with("the path names no file"), "{error}");
    assert_eq!(names(folder.path()), ["file"]);

    let long = at(&format!("{}.png", "x".repeat(300)));
    let error = match SafeFile::create(&long) {
        Ok(file) => file.commit().unwrap_err(),
        Err(error) => error,
    };
    assert!(error.to_string().starts_with("cannot write "), "{error}");
    assert_eq!(names(folder.path()), ["file"]);
}

#[cfg(target_os = "linux")]
mod linux {
    use super::*;
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    #[test]
    fn a_full_device_is_an_error() {
        let mut file = SafeFile::create(Path::new("/dev/full")).unwrap();
        let error = file.write_all(b"x").unwrap_err();
        assert_eq!(error.kind(), ErrorKind::StorageFull);
        let text = error.to_string();
        assert!(text.starts_with("cannot write /dev/full: "), "{text}");
        assert!(text.ends_with("; free some space or choose another folder"), "{text}");
        // Written through: the device is still one.
        assert!(!fs::metadata("/dev/full").unwrap().is_file());
        assert!(stray_files(Path::new("/dev")).unwrap().is_empty());
    }

    #[test]
    fn a_symlink_keeps_pointing() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("there")).unwrap();
        fs::write(at("there/real.png"), b"old").unwrap();
        symlink("there/real.png", at("link.png")).unwrap();
        symlink(at("link.png"), at("second.png")).unwrap();
        write(&at("second.png"), b"new").unwrap();
        assert_eq!(fs::read(at("there/real.png")).unwrap(), b"new");
        assert!(at("link.png").is_symlink() && at("second.png").is_symlink());
        assert_eq!(names(&at("there")), ["real.png"]);

        // One that points nowhere yet, into a folder that is not there yet.
        symlink("else/b.png", at("dangling.png")).unwrap();
        write(&at("dangling.png"), b"b").unwrap();
        assert_eq!(fs::read(at("else/b.png")).unwrap(), b"b");

        symlink("loop.png", at("loop.png")).unwrap();
        let error = SafeFile::create(&at("loop.png")).unwrap_err().to_string();
        assert!(error.contains("symbolic links"), "{error}");

        symlink("/dev/full", at("full.png")).unwrap();
        let error = write(&at("full.png"), b"x").unwrap_err();
        assert_eq!(error.kind(), ErrorKind::StorageFull);
        assert!(at("full.png").is_symlink());
    }

    #[test]
    fn a_pipe_is_written_through() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        let made = Command::new("mkfifo").arg(&path).status();
        if !made.is_ok_and(|status| status.success()) {
            eprintln!("skipped: there is no mkfifo");
            return;
        }
        let reader = {
            let path = path.clone();
            std::thread::spawn(move || {
                let mut bytes = Vec::new();
                fs::File::open(path).unwrap().read_to_end(&mut bytes).unwrap();
                bytes
            })
        };
        write(&path, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert_eq!(names(folder.path()), ["pipe"]);
    }

    #[test]
    fn a_hard_link_keeps_the_old_bytes_and_the_mode_stays() {
        let folder = tempfile::tempdir().unwrap();
        let (path, other) = (folder.path().join("a"), folder.path().join("b"));
        fs::write(&path, b"old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        fs::hard_link(&path, &other).unwrap();
        write(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read(&other).unwrap(), b"old");
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, 0o640);
        assert_eq!(names(folder.path()), ["a", "b"]);
    }

    /// This test binary, to run its `child` test with `job`.
    fn process(job: &str, folder: &Path) -> Command {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command
            .args(["--exact", "linux::child", "--nocapture"])
            .env("REFLET_FILM_JOB", job)
            .env("REFLET_FILM_FOLDER", folder);
        command
    }

    #[test]
    fn child() {
        let Ok(job) = std::env::var("REFLET_FILM_JOB") else {
            return;
        };
        let folder = PathBuf::from(std::env::var("REFLET_FILM_FOLDER").unwrap());
        let path = match job.as_str() {
            "stdout" => PathBuf::from("/dev/stdout"),
            _ => folder.join("a.png"),
        };
        let mut file = SafeFile::create(&path).unwrap();
        match job.as_str() {
            "abort" => {
                file.write_all(&[1; 100_000]).unwrap();
                std::process::abort();
            }
            "stdout" => {
                file.write_all(b"through").unwrap();
                file.commit().unwrap();
            }
            _ => {
                let error = file.write_all(&vec![1; 1 << 20]).and_then(|()| file.commit());
                println!("error: {}", error.unwrap_err());
            }
        }
    }

    #[test]
    fn a_killed_process_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, b"old").unwrap();
        let mut process = process("abort", folder.path()).spawn().unwrap();
        assert!(!process.wait().unwrap().success());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        let strays = stray_files(folder.path()).unwrap();
        assert_eq!(strays.len(), 1);
        assert!(!strays[0].is_ours());
        // The next run is not in its way.
        write(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        // Its lock has ended with it.
        assert!(strays[0].remove_orphan().unwrap());
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn a_full_disk_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let mount = |arguments: &[&str]| {
            let done = Command::new(arguments[0]).args(&arguments[1..]).arg(folder.path()).status();
            done.is_ok_and(|status| status.success())
        };
        let size = ["mount", "-t", "tmpfs", "-o", "size=256k", "reflet-test"];
        if !mount(&size) {
            eprintln!("skipped: a tmpfs cannot be mounted here");
            return;
        }
        let path = folder.path().join("a.png");
        fs::write(&path, b"old").unwrap();
        let output = process("fill", folder.path()).output().unwrap();
        let (old, left) = (fs::read(&path).unwrap(), names(folder.path()));
        let unmounted = mount(&["umount"]);
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(
            text.contains("error: cannot write ") && text.contains("free some space"),
            "{text}"
        );
        assert_eq!(old, b"old");
        assert_eq!(left, ["a.png"]);
        assert!(unmounted);
    }

    #[test]
    fn a_read_only_folder_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("locked");
        fs::create_dir(&inner).unwrap();
        fs::set_permissions(&inner, fs::Permissions::from_mode(0o555)).unwrap();
        match SafeFile::create(&inner.join("a.png")) {
            Err(error) => {
                assert_eq!(error.kind(), ErrorKind::PermissionDenied);
                let text = error.to_string();
                assert!(text.ends_with("; choose a folder that you may write to"), "{text}");
            }
            // The superuser may write everywhere, except where there are no files to be made.
            Ok(file) => {
                drop(file);
                let error = SafeFile::create(Path::new("/proc/reflet/a.png")).unwrap_err();
                assert!(error.to_string().contains("/proc/reflet"), "{error}");
            }
        }
        assert!(names(&inner).is_empty());
    }

    #[test]
    fn standard_output_under_its_other_name_is_written_through() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        let output = fs::File::create(&path).unwrap();
        let before = fs::metadata(&path).unwrap().ino();
        let mut command = process("stdout", folder.path());
        assert!(command.stdout(output).status().unwrap().success());
        // The file that the shell opened, not a new one in its place. (The test runner's own lines
        // stand in it too.)
        assert_eq!(fs::metadata(&path).unwrap().ino(), before);
        assert!(fs::read(&path).unwrap().starts_with(b"through"));
        assert_eq!(names(folder.path()), ["out"]);
    }
}

#[test]
fn a_target_opens_the_file_of_each_frame() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("film/frame.png");
    let target = Target::parse(out.as_os_str(), None, 3).unwrap();
    assert_eq!(target.format(), Format::Png);
    assert!(target.is_numbered() && !target.is_stdout());
    for frame in 0..3 {
        let mut file = target.open(frame).unwrap();
        file.write_all(&[frame as u8]).unwrap();
        file.commit().unwrap();
    }
    assert_eq!(
        names(&folder.path().join("film")),
        ["frame-0000.png", "frame-0001.png", "frame-0002.png"]
    );
    let stdout = Target::parse(OsStr::new("-"), None, 3).unwrap();
    assert_eq!(stdout.open(0).unwrap().path(), Path::new("-"));
}
