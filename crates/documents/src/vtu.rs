//! VTU, the file of ParaView for unstructured grids: ten-node tetrahedra with displacement fields.

use std::fmt::Write;

/// One field of displacements.
pub struct VtuField<'a> {
    /// Its name.
    pub name: String,
    /// One vector for each node.
    pub values: &'a [[f64; 3]],
}

fn array(out: &mut String, kind: &str, name: &str, components: usize, bytes: &[u8]) {
    let safe: String = name
        .chars()
        .map(|c| {
            if matches!(c, '<' | '>' | '&' | '"') {
                '_'
            } else {
                c
            }
        })
        .collect();
    let _ = write!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{safe}\" NumberOfComponents=\"{components}\" format=\"binary\">"
    );
    let mut all = (bytes.len() as u64).to_le_bytes().to_vec();
    all.extend_from_slice(bytes);
    crate::base64::append(&all, out);
    out.push_str("</DataArray>\n");
}

/// A grid of ten-node tetrahedra (corners, then the middles of the edges 01, 12, 20, 03, 13, 23) with fields at its nodes and a
/// number for each element.
///
/// Single precision, base64 inline, little-endian: read by ParaView 5 and by VTK.
pub fn vtu(
    nodes: &[[f64; 3]],
    elements: &[[u32; 10]],
    regions: &[u16],
    fields: &[VtuField<'_>],
) -> Vec<u8> {
    let floats = |values: &[[f64; 3]]| -> Vec<u8> {
        values
            .iter()
            .flatten()
            .flat_map(|v| (*v as f32).to_le_bytes())
            .collect()
    };
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n",
    );
    let _ = writeln!(
        out,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData>",
        nodes.len(),
        elements.len()
    );
    for field in fields {
        array(&mut out, "Float32", &field.name, 3, &floats(field.values));
    }
    out.push_str("</PointData>\n<CellData>\n");
    let regions: Vec<u8> = regions
        .iter()
        .flat_map(|r| i32::from(*r).to_le_bytes())
        .collect();
    array(&mut out, "Int32", "region", 1, &regions);
    out.push_str("</CellData>\n<Points>\n");
    array(&mut out, "Float32", "Points", 3, &floats(nodes));
    out.push_str("</Points>\n<Cells>\n");
    let connectivity: Vec<u8> = elements
        .iter()
        .flatten()
        .flat_map(|n| i64::from(*n).to_le_bytes())
        .collect();
    array(&mut out, "Int64", "connectivity", 1, &connectivity);
    let offsets: Vec<u8> = (1..=elements.len() as i64)
        .flat_map(|n| (10 * n).to_le_bytes())
        .collect();
    array(&mut out, "Int64", "offsets", 1, &offsets);
    // 24 is VTK_QUADRATIC_TETRA.
    array(&mut out, "UInt8", "types", 1, &vec![24; elements.len()]);
    out.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    out.into_bytes()
}
