//! Gmsh meshes, `.msh` in text form, versions 2.2 and 4.1: tetrahedra and triangles of first and second order.

use proofmass_io::{Error, ErrorKind, Result};
use std::collections::BTreeMap;
use std::path::Path;
use std::str::SplitAsciiWhitespace;

/// Nodes, and elements as indices into them, each with the name of its physical group.
///
/// Ten-node tetrahedra have their nodes in the order corners, then the middles of the edges 01, 12, 20, 03, 13, 23; six-node triangles
/// corners, then the middles of 01, 12, 20.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct GmshMesh {
    /// Coordinates in the unit of the file.
    pub nodes: Vec<[f64; 3]>,
    /// Tetrahedra of four nodes, and group.
    pub tetrahedra: Vec<([u32; 4], usize)>,
    /// Tetrahedra of ten nodes, and group.
    pub quadratic_tetrahedra: Vec<([u32; 10], usize)>,
    /// Corners of triangles of either order, and group.
    pub triangles: Vec<([u32; 3], usize)>,
    /// Names of the groups: those of the file, or the number of an unnamed one.
    pub groups: Vec<String>,
}

/// Words of the file, with the line they stand in.
struct Words<'a> {
    lines: Vec<&'a str>,
    line: usize,
    rest: SplitAsciiWhitespace<'a>,
    path: &'a Path,
}

impl<'a> Words<'a> {
    fn fail(&self, what: impl Into<String>) -> Error {
        Error::new(ErrorKind::Format, what)
            .at(self.path)
            .line(self.line as u64)
    }

    fn next(&mut self) -> Result<&'a str> {
        loop {
            if let Some(word) = self.rest.next() {
                return Ok(word);
            }
            let Some(line) = self.lines.get(self.line) else {
                return Err(self
                    .fail("the mesh ends in the middle")
                    .with_hint("export it again: the file was not written whole"));
            };
            self.line += 1;
            self.rest = line.split_ascii_whitespace();
        }
    }

    fn integer(&mut self) -> Result<i64> {
        let word = self.next()?;
        word.parse()
            .map_err(|_| self.fail(format!("`{word}` is not a whole number")))
    }

    fn count(&mut self) -> Result<usize> {
        let n = self.integer()?;
        usize::try_from(n).map_err(|_| self.fail(format!("{n} is not a valid count")))
    }

    fn number(&mut self) -> Result<f64> {
        let word = self.next()?;
        match word.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(v),
            _ => Err(self.fail(format!("`{word}` is not a finite number"))),
        }
    }

    /// What is left of the line just begun.
    fn quoted(&mut self) -> String {
        let line = self.lines.get(self.line.wrapping_sub(1)).unwrap_or(&"");
        self.rest = "".split_ascii_whitespace();
        line.split('"').nth(1).unwrap_or_default().to_owned()
    }

    fn expect(&mut self, end: &str) -> Result<()> {
        let word = self.next()?;
        if word == end {
            return Ok(());
        }
        Err(self.fail(format!("{end} is expected, and the file has `{word}`")))
    }

    /// Passes a section that is of no use here.
    fn skip(&mut self, end: &str) -> Result<()> {
        loop {
            if self.next()? == end {
                return Ok(());
            }
        }
    }
}

/// Nodes of the element types of Gmsh that may stand in a file beside those that are used.
const SIZES: [(i64, usize); 20] = [
    (1, 2),
    (2, 3),
    (3, 4),
    (4, 4),
    (5, 8),
    (6, 6),
    (7, 5),
    (8, 3),
    (9, 6),
    (10, 9),
    (11, 10),
    (12, 27),
    (13, 18),
    (14, 14),
    (15, 1),
    (16, 8),
    (17, 20),
    (18, 15),
    (19, 13),
    (21, 10),
];

#[derive(Default)]
struct Reader {
    mesh: GmshMesh,
    /// Index of a node by its tag.
    tags: BTreeMap<i64, u32>,
    /// Physical names by dimension and tag.
    names: BTreeMap<(i64, i64), String>,
    /// Physical tag of an entity by dimension and tag, version 4.
    entities: BTreeMap<(i64, i64), i64>,
    /// Index of a group by dimension and physical tag.
    groups: BTreeMap<(i64, i64), usize>,
}

impl GmshMesh {
    /// Reads the text of a mesh; `path` is for messages.
    ///
    /// # Errors
    /// A binary file, another version, a word that is no number, a node that is not there, elements other than tetrahedra in the
    /// volume (hexahedra, prisms, pyramids, higher orders): with the line.
    ///
    /// ```
    /// let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n\
    ///             $Elements\n1\n1 4 2 7 1 1 2 3 4\n$EndElements\n";
    /// let mesh = proofmass_documents::GmshMesh::parse(text, "block.msh".as_ref())?;
    /// assert_eq!(mesh.tetrahedra, [([0, 1, 2, 3], 0)]);
    /// assert_eq!(mesh.groups, ["7"]);
    /// # Ok::<(), proofmass_io::Error>(())
    /// ```
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let mut words = Words {
            lines: text.lines().collect(),
            line: 0,
            rest: "".split_ascii_whitespace(),
            path,
        };
        let mut reader = Reader::default();
        let mut version = None;
        while words.line < words.lines.len() {
            let line = words.lines[words.line].trim();
            words.line += 1;
            match line {
                "$MeshFormat" => {
                    let number = words.number()?;
                    if words.integer()? != 0 {
                        return Err(words
                            .fail("the mesh is in binary form")
                            .with_hint("save it as text: `gmsh -3 -format msh41 -bin 0`, or untick Binary in the export dialog"));
                    }
                    if number != 2.2 && number != 4.1 {
                        return Err(words
                            .fail(format!("version {number} of the format is not known"))
                            .with_hint("save it as version 4.1 or 2.2 ASCII"));
                    }
                    words.integer()?;
                    words.expect("$EndMeshFormat")?;
                    version = Some(number);
                }
                "$PhysicalNames" => reader.physical_names(&mut words)?,
                "$Entities" => reader.entities(&mut words)?,
                "$Nodes" => match version {
                    Some(4.1) => reader.nodes4(&mut words)?,
                    Some(_) => reader.nodes2(&mut words)?,
                    None => return Err(words.fail("nodes stand before $MeshFormat")),
                },
                "$Elements" => match version {
                    Some(4.1) => reader.elements4(&mut words)?,
                    Some(_) => reader.elements2(&mut words)?,
                    None => return Err(words.fail("elements stand before $MeshFormat")),
                },
                other => {
                    if let Some(name) = other.strip_prefix('$') {
                        let end = format!("$End{name}");
                        words.skip(&end)?;
                    } else if version.is_none() && !other.is_empty() {
                        return Err(words
                            .fail("the file is no Gmsh mesh: $MeshFormat is missing")
                            .with_hint("export .msh from Gmsh, version 4.1 or 2.2 ASCII"));
                    }
                }
            }
        }
        if version.is_none() {
            return Err(words
                .fail("the file is no Gmsh mesh: $MeshFormat is missing")
                .with_hint("export .msh from Gmsh, version 4.1 or 2.2 ASCII"));
        }
        if reader.mesh.tetrahedra.is_empty() && reader.mesh.quadratic_tetrahedra.is_empty() {
            return Err(words.fail("the mesh has no tetrahedra").with_hint(
                "mesh the volume (`gmsh -3`); with physical groups the volume needs one too",
            ));
        }
        Ok(reader.mesh)
    }
}

impl Reader {
    fn physical_names(&mut self, words: &mut Words<'_>) -> Result<()> {
        for _ in 0..words.count()? {
            let key = (words.integer()?, words.integer()?);
            let name = words.quoted();
            self.names.insert(key, name);
        }
        words.expect("$EndPhysicalNames")
    }

    fn entities(&mut self, words: &mut Words<'_>) -> Result<()> {
        let counts = [
            words.count()?,
            words.count()?,
            words.count()?,
            words.count()?,
        ];
        for (dimension, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                let tag = words.integer()?;
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    words.number()?;
                }
                for k in 0..words.count()? {
                    let physical = words.integer()?;
                    if k == 0 {
                        self.entities.insert((dimension as i64, tag), physical);
                    }
                }
                if dimension > 0 {
                    for _ in 0..words.count()? {
                        words.integer()?;
                    }
                }
            }
        }
        words.expect("$EndEntities")
    }

    fn node(&mut self, tag: i64, at: [f64; 3]) {
        self.tags.insert(tag, self.mesh.nodes.len() as u32);
        self.mesh.nodes.push(at);
    }

    fn nodes2(&mut self, words: &mut Words<'_>) -> Result<()> {
        for _ in 0..words.count()? {
            let tag = words.integer()?;
            let at = [words.number()?, words.number()?, words.number()?];
            self.node(tag, at);
        }
        words.expect("$EndNodes")
    }

    fn nodes4(&mut self, words: &mut Words<'_>) -> Result<()> {
        let blocks = words.count()?;
        for _ in 0..3 {
            words.integer()?;
        }
        for _ in 0..blocks {
            let dimension = words.count()?;
            words.integer()?;
            let parametric = words.integer()? != 0;
            let count = words.count()?;
            let mut tags = Vec::new();
            for _ in 0..count {
                tags.push(words.integer()?);
            }
            for tag in tags {
                let at = [words.number()?, words.number()?, words.number()?];
                if parametric {
                    for _ in 0..dimension {
                        words.number()?;
                    }
                }
                self.node(tag, at);
            }
        }
        words.expect("$EndNodes")
    }

    fn elements2(&mut self, words: &mut Words<'_>) -> Result<()> {
        for _ in 0..words.count()? {
            words.integer()?;
            let kind = words.integer()?;
            let mut physical = 0;
            for k in 0..words.count()? {
                let tag = words.integer()?;
                if k == 0 {
                    physical = tag;
                }
            }
            self.element(words, kind, physical)?;
        }
        words.expect("$EndElements")
    }

    fn elements4(&mut self, words: &mut Words<'_>) -> Result<()> {
        let blocks = words.count()?;
        for _ in 0..3 {
            words.integer()?;
        }
        for _ in 0..blocks {
            let key = (words.integer()?, words.integer()?);
            let kind = words.integer()?;
            let physical = self.entities.get(&key).copied().unwrap_or(0);
            for _ in 0..words.count()? {
                words.integer()?;
                self.element(words, kind, physical)?;
            }
        }
        words.expect("$EndElements")
    }

    fn group(&mut self, dimension: i64, physical: i64) -> usize {
        let key = (dimension, physical);
        if let Some(&group) = self.groups.get(&key) {
            return group;
        }
        let name = self.names.get(&key).cloned();
        self.mesh
            .groups
            .push(name.unwrap_or_else(|| physical.to_string()));
        self.groups.insert(key, self.mesh.groups.len() - 1);
        self.mesh.groups.len() - 1
    }

    fn element(&mut self, words: &mut Words<'_>, kind: i64, physical: i64) -> Result<()> {
        let Some(&(_, size)) = SIZES.iter().find(|s| s.0 == kind) else {
            return Err(words
                .fail(format!("elements of type {kind} are not known"))
                .with_hint("mesh with tetrahedra of order 1 or 2: Mesh.ElementOrder = 2"));
        };
        let mut nodes = [0u32; 27];
        for slot in &mut nodes[..size] {
            let tag = words.integer()?;
            *slot = *self
                .tags
                .get(&tag)
                .ok_or_else(|| words.fail(format!("node {tag} is not in the mesh")))?;
        }
        let n = nodes;
        match kind {
            4 => {
                let group = self.group(3, physical);
                self.mesh.tetrahedra.push(([n[0], n[1], n[2], n[3]], group));
            }
            11 => {
                let group = self.group(3, physical);
                // Gmsh has the middles of 23 and 13 the other way round.
                let e = [n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[9], n[8]];
                self.mesh.quadratic_tetrahedra.push((e, group));
            }
            2 | 9 => {
                let group = self.group(2, physical);
                self.mesh.triangles.push(([n[0], n[1], n[2]], group));
            }
            5 | 6 | 7 | 12 | 13 | 14 | 17 | 18 | 19 => {
                return Err(words
                    .fail("the volume holds hexahedra, prisms or pyramids")
                    .with_hint("mesh it with tetrahedra only: no Recombine, no transfinite volume with Recombine"));
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const V4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 5 \"the base\"\n3 6 \"body\"\n$EndPhysicalNames\n\
        $Entities\n0 0 1 1\n1 0 0 0 1 1 0 1 5 0\n1 0 0 0 1 1 1 1 6 0\n$EndEntities\n\
        $Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n\
        $Elements\n2 2 1 2\n2 1 2 1\n1 1 3 2\n3 1 4 1\n2 1 2 3 4\n$EndElements\n";

    #[test]
    fn known_version_4_with_groups() {
        let mesh = GmshMesh::parse(V4, Path::new("a.msh")).unwrap();
        assert_eq!(mesh.groups, ["the base", "body"]);
        assert_eq!(mesh.triangles, [([0, 2, 1], 0)]);
        assert_eq!(mesh.tetrahedra, [([0, 1, 2, 3], 1)]);
    }

    #[test]
    fn refuses_what_is_no_such_mesh() {
        let fail = |text: &str| {
            GmshMesh::parse(text, Path::new("a.msh"))
                .unwrap_err()
                .to_string()
        };
        assert!(fail("solid stl\n").contains("no Gmsh mesh"));
        assert!(fail("").contains("no Gmsh mesh"));
        assert!(fail("$MeshFormat\n4.1 1 8\n").contains("binary"));
        assert!(fail("$MeshFormat\n3.0 0 8\n").contains("version 3"));
        for cut in 0..V4.len() {
            // A file cut anywhere is refused or read, never a panic.
            let _ = GmshMesh::parse(&V4[..cut], Path::new("a.msh"));
        }
        assert!(fail(&V4.replace("\n2 1 2 3 4\n", "\n2 1 2 3 9\n")).contains("node 9"));
        assert!(
            fail(&V4.replace("3 1 4 1\n2 1 2 3 4", "3 1 5 1\n2 1 2 3 4 1 2 3 4"))
                .contains("hexahedra")
        );
        assert!(fail(&V4.replace("0 0 1\n$EndNodes", "0 0 nan\n$EndNodes")).contains("nan"));
        // A count beyond the file does not take memory for it.
        let said = fail(&V4.replace("$Nodes\n1 4 1 4\n", "$Nodes\n99999999999 4 1 4\n"));
        assert!(said.contains("`$EndNodes` is not a whole number"), "{said}");
    }
}
