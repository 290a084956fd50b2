//! Names of files as programs write them on systems that do not tell upper from lower case.

use std::path::{Component, Path, PathBuf};

/// The entries of a folder that are looked at.
const ENTRIES: usize = 100_000;

/// The path below `root` that differs from `file` by upper and lower case alone, if there is one and
/// no more. It is a name like any other: whether it may be read is not said.
pub(crate) fn any_case(root: &Path, file: &Path) -> Option<PathBuf> {
    let mut found = PathBuf::new();
    for component in file.components() {
        let Component::Normal(name) = component else {
            if component == Component::CurDir {
                continue;
            }
            return None;
        };
        let folder = root.join(&found);
        if folder.join(name).symlink_metadata().is_ok() {
            found.push(name);
            continue;
        }
        let wanted = name.to_str()?.to_lowercase();
        let entries = std::fs::read_dir(folder).ok()?.take(ENTRIES).flatten();
        let names = entries.map(|entry| entry.file_name());
        let mut same =
            names.filter(|name| name.to_str().is_some_and(|n| n.to_lowercase() == wanted));
        match (same.next(), same.next()) {
            (Some(name), None) => found.push(name),
            _ => return None,
        }
    }
    Some(found)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_name_of_another_case_is_found_if_it_is_the_only_one() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir(dir.path().join("Textures")).unwrap();
        for name in ["Textures/Wood.PNG", "Textures/two.png", "Textures/TWO.png"] {
            std::fs::write(dir.path().join(name), b"").unwrap();
        }
        let find = |name: &str| any_case(dir.path(), Path::new(name));
        assert_eq!(find("textures/wood.png"), Some("Textures/Wood.PNG".into()));
        assert_eq!(find("./TEXTURES/two.png"), Some("Textures/two.png".into()));
        assert_eq!(find("Textures/Two.png"), None);
        assert_eq!(find("../x"), None);
        assert_eq!(find("textures/none.png"), None);
    }
}
