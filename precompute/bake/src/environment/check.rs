//! Reading and checking files of unit objects.

use super::{UnitObject, UnitSet, UnitShape};
use std::{collections::BTreeSet, path::Path};
use throng_base::text::TomlSource;
use throng_motion::error::{BuildError, Result, ensure};

/// Upper bound of sizes and positions within a unit (m).
const MAX_LENGTH: f32 = 1e4;
/// Most units of a file.
const MAX_UNITS: usize = 10_000;

impl UnitSet {
    /// Reads a file of unit objects; mesh files are taken from its folder.
    ///
    /// # Errors
    /// [`BuildError::Io`], or [`BuildError::File`] with file, line, column and key.
    pub fn load(path: &Path) -> Result<Self> {
        Self::from_source(&TomlSource::read(path, "a unit file")?)
    }

    /// Reads the text of a unit file; mesh files are taken from the folder of `path`.
    ///
    /// # Errors
    /// As [`UnitSet::load`].
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        Self::from_source(&TomlSource::new(text, path))
    }

    fn from_source(source: &TomlSource) -> Result<Self> {
        let help = "A unit file has `[[units]]` with `name`, `shapes`, `region`, `symmetry`, `tile` and `floor`.";
        let mut set: Self = source.parse(help)?;
        let folder = source.path().parent().unwrap_or(Path::new(""));
        for shape in set.units.iter_mut().flat_map(|u| &mut u.shapes) {
            if let UnitShape::Mesh { file } = shape {
                *file = folder.join(&file);
            }
        }
        set.check().map_err(|e| e.with_position(source))?;
        Ok(set)
    }

    /// The units as TOML, as bundles and worlds keep them.
    ///
    /// # Errors
    /// [`BuildError::Config`] where a value cannot be written.
    pub fn to_toml(&self) -> Result<String> {
        toml::to_string(self).map_err(|e| BuildError::Config { message: e.to_string() })
    }

    fn check(&self) -> Result<()> {
        if self.units.len() > MAX_UNITS {
            return Err(BuildError::key("units", format!("expected {MAX_UNITS} at most, found {}", self.units.len())));
        }
        let mut names = BTreeSet::new();
        for (i, unit) in self.units.iter().enumerate() {
            let within = |e: BuildError| e.within_key(&format!("units[{i}]"));
            let why = || format!("another unit is called `{}`; rename one of them", unit.name);
            ensure(names.insert(&unit.name), || within(BuildError::key("name", why())))?;
            check_unit(unit).map_err(within)?;
        }
        Ok(())
    }
}

fn check_unit(unit: &UnitObject) -> Result<()> {
    let fault = |key: &str, why: String| Err(BuildError::key(key, why));
    if unit.name.is_empty() || unit.name.contains('+') {
        return fault("name", "expected a name without `+`, which joins the names of blocks".into());
    }
    for (i, shape) in unit.shapes.iter().enumerate() {
        check_shape(shape).map_err(|e| e.within_key(&format!("shapes[{i}]")))?;
    }
    if let Some(region) = unit.region {
        check_magnitude("region.min", &region.min)?;
        check_magnitude("region.max", &region.max)?;
        if (0..3).any(|k| region.min[k] >= region.max[k]) {
            return fault("region", format!("expected min below max, found {:?} and {:?}", region.min, region.max));
        }
    }
    if !(1..=360).contains(&unit.symmetry) {
        let why = "expected 1 to 360, found";
        return fault("symmetry", format!("{why} {}; 1 is a unit without symmetry", unit.symmetry));
    }
    let Some(tile) = &unit.tile else { return Ok(()) };
    let (steps, widths) = (tile.steps.len(), tile.widths.len());
    if steps != widths || !(1..=2).contains(&steps) {
        return fault("tile", format!("expected 1 or 2 steps and as many widths, found {steps} and {widths}"));
    }
    tile.steps.iter().try_for_each(|s| check_magnitude("tile.steps", s))?;
    check_positive("tile.widths", &tile.widths)?;
    check_magnitude("tile.centre", &tile.centre)?;
    if tile.steps.iter().any(|s| s[0].hypot(s[2]) < 0.1) {
        return fault("tile.steps", "expected steps of at least 0.1 m over the ground".into());
    }
    Ok(())
}

fn check_shape(shape: &UnitShape) -> Result<()> {
    match shape {
        UnitShape::Box { at, size, heading_deg, pitch_deg } => {
            check_magnitude("box.at", at)?;
            check_magnitude("box.heading_deg", &[*heading_deg])?;
            check_magnitude("box.pitch_deg", &[*pitch_deg])?;
            check_positive("box.size", size)
        }
        UnitShape::Bar { from, to, radius } => {
            check_magnitude("bar.from", from)?;
            check_magnitude("bar.to", to)?;
            check_positive("bar.radius", &[*radius])
        }
        UnitShape::Mesh { file } if file.is_file() => Ok(()),
        UnitShape::Mesh { file } => Err(BuildError::key("mesh.file", format!("there is no file {}", file.display()))),
    }
}

fn check_magnitude(key: &str, numbers: &[f32]) -> Result<()> {
    match numbers.iter().find(|v| v.is_nan() || v.abs() >= MAX_LENGTH) {
        Some(v) => Err(BuildError::key(key, format!("expected finite numbers below {MAX_LENGTH}, found {v}"))),
        None => Ok(()),
    }
}

fn check_positive(key: &str, numbers: &[f32]) -> Result<()> {
    match numbers.iter().find(|v| !(**v > 0.0 && **v < MAX_LENGTH)) {
        Some(v) => Err(BuildError::key(key, format!("expected numbers above 0 and below {MAX_LENGTH}, found {v}"))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> String {
        UnitSet::parse(text, Path::new("u.toml")).unwrap_err().to_string()
    }

    fn unit(keys: &str) -> String {
        fault(&format!("[[units]]\nname = \"a\"\n{keys}\n"))
    }

    #[test]
    fn faults_name_file_unit_and_key() {
        let e = unit("shapes = [{ box = { at = [0.0, 0.0, 0.0], size = [1.0, -1.0, 1.0] } }]");
        let key = "units[0].shapes[0].box.size";
        assert_eq!(e, format!("u.toml:3:43: {key}: expected numbers above 0 and below 10000, found -1"));
        let e = unit("shapes = [{ bar = { from = [0.0, inf, 0.0], to = [1.0, 1.0, 1.0], radius = 0.1 } }]");
        assert!(e.contains("shapes[0].bar.from: expected finite numbers"), "{e}");
        let e = unit("shapes = [{ bar = { from = [0.0, 0.0, 0.0], to = [1.0, 1.0, 1.0], radius = nan } }]");
        assert!(e.contains("shapes[0].bar.radius: expected numbers above 0"), "{e}");
        let e = unit("shapes = [{ mesh = { file = \"no-such.glb\" } }]");
        assert!(e.contains("shapes[0].mesh.file: there is no file no-such.glb"), "{e}");
        assert!(unit("symmetry = 0").contains("u.toml:3:1: units[0].symmetry: expected 1 to 360, found 0"));
        let e = unit("region = { min = [0.0, 0.0, 0.0], max = [1.0, 0.0, 1.0] }");
        assert!(e.contains("region: expected min below max"), "{e}");
        let e = unit("tile = { steps = [[1.0, 0.0, 0.0]], widths = [1.0, 2.0] }");
        assert!(e.contains("tile: expected 1 or 2 steps and as many widths, found 1 and 2"), "{e}");
        let e = unit("tile = { steps = [[1.0, 0.0, 0.0]], widths = [1.0], centre = [0.0, nan, 0.0] }");
        assert!(e.contains("tile.centre: expected finite numbers"), "{e}");
        let e = fault(&"[[units]]\nname = \"a\"\n".repeat(10_001));
        assert!(e.contains("units: expected 10000 at most, found 10001"), "{e}");
        assert!(unit("tile = { steps = [[0.0, 1.0, 0.0]], widths = [1.0] }").contains("over the ground"));
        assert!(unit("[[units]]\nname = \"a\"").contains("u.toml:4:1: units[1].name: another unit is called `a`"));
        assert!(unit("[[units]]\nname = \"a+b\"").contains("without `+`"));
        assert!(unit("shaeps = []").contains("u.toml:3:1: unknown field `shaeps`"));
    }

    #[test]
    fn what_is_written_reads_back_and_meshes_lie_beside_the_file() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("m.glb"), b"").unwrap();
        let text = "[[units]]\nname = \"a\"\nfloor = true\nregion = { min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }\n\
                    shapes = [{ mesh = { file = \"m.glb\" } }, { box = { at = [0.0, 0.0, 0.0], size = [1.0, 1.0, 1.0], \
                    pitch_deg = 30.0 } }]\n";
        let path = folder.path().join("u.toml");
        std::fs::write(&path, text).unwrap();
        let set = UnitSet::load(&path).unwrap();
        assert_eq!(set.units[0].shapes[0], UnitShape::Mesh { file: folder.path().join("m.glb") });
        assert_eq!(set.units[0].symmetry, 1);
        let again = UnitSet::parse(&set.to_toml().unwrap(), Path::new("x.toml")).unwrap();
        assert_eq!(again, set);
    }
}
