//! The image for the memory of a sensor module, and a C99 header that reads any such image.

use super::{Plan, c, literal, unable};
use proofmass_core::{
    CalibrationMemory, LARGEST_MEMORY, MEMORY_SERIAL, MemoryUnit, StoredCompensation,
};
use proofmass_io::{Result, Unit};
use proofmass_signal::AnyCompensation;
use std::fmt::Write;

fn unit_of(unit: Unit) -> Result<MemoryUnit> {
    Ok(match unit {
        Unit::Count => MemoryUnit::Count,
        Unit::Volt => MemoryUnit::Volt,
        Unit::MetrePerSecondSquared => MemoryUnit::MetrePerSecondSquared,
        Unit::StandardGravity => MemoryUnit::StandardGravity,
        other => {
            return Err(unable(
                &format!("a calibration memory has no code for outputs in {other}"),
                "its outputs are in count, V, m/s² or g",
            ));
        }
    })
}

/// The unit of a stored calibration as a heading has it.
pub(crate) fn unit_from(unit: MemoryUnit) -> Unit {
    match unit {
        MemoryUnit::Count => Unit::Count,
        MemoryUnit::Volt => Unit::Volt,
        MemoryUnit::MetrePerSecondSquared => Unit::MetrePerSecondSquared,
        _ => Unit::StandardGravity,
    }
}

pub(super) fn image(plan: &Plan<'_>) -> Result<Vec<u8>> {
    let file = plan.file;
    let stored = match &plan.model {
        AnyCompensation::OneAxis(model) => StoredCompensation::OneAxis(model.cast()),
        AnyCompensation::ThreeAxes(model) => StoredCompensation::ThreeAxes(model.cast()),
    };
    let serial = file.device.serial.as_deref().unwrap_or_default();
    let mut source = [0; 8];
    if let Some(input) = plan.source {
        let digits = input.sha256.as_bytes().chunks(2).take(8);
        for (byte, digits) in source.iter_mut().zip(digits) {
            let digits = str::from_utf8(digits).unwrap_or_default();
            *byte = u8::from_str_radix(digits, 16).unwrap_or_default();
        }
    }
    let memory = CalibrationMemory::new(serial, source, unit_of(file.input_unit)?, stored);
    let memory = memory.map_err(|_| {
        unable(
            &format!("the serial number {serial:?} has more than {MEMORY_SERIAL} bytes, or a zero in it"),
            "a calibration memory keeps it whole; shorten `serial` in [device] of the campaign, and calibrate again",
        )
    })?;
    let reach = file.curvature.as_ref().map_or(0.0, |c| c.reach);
    let mut bytes = vec![0; LARGEST_MEMORY];
    let length = memory.reach(reach as f32).write(&mut bytes);
    bytes.truncate(length.unwrap_or_default());
    // A coefficient that is beyond single precision is refused as the chip would refuse it.
    CalibrationMemory::read(&bytes).map_err(|e| {
        unable(
            &format!("a coefficient does not fit into single precision: {e}"),
            "write it with --number double as source code",
        )
    })?;
    Ok(bytes)
}

pub(super) fn reader(plan: &Plan<'_>) -> Result<String> {
    let bytes = image(plan)?;
    let name = &plan.name;
    let guard = format!("{}_H", name.to_ascii_uppercase());
    let mut text = String::from("/*\n");
    for line in plan.heading() {
        let _ = writeln!(text, " * {line}");
    }
    let _ = write!(
        text,
        " * Reads the calibration memory of any device; the one above is in {name}_self_check(), which returns 0 when this compiler\n \
         * computes from it what the desk computed. C99, no library, no allocation.\n */\n#ifndef {guard}\n#define {guard}\n\n\
         #include <stddef.h>\n#include <stdint.h>\n"
    );
    text.push_str(&BODY.replace("NAME", name));
    text.push_str(&c::outside_of_a_memory(name));
    text.push_str(&APPLY.replace("NAME", name));
    self_check(&mut text, plan, &bytes);
    let _ = writeln!(text, "#endif");
    Ok(text)
}

const BODY: &str = r#"
/* Why bytes are no calibration memory. */
enum {
    NAME_OK = 0,
    NAME_NOT_A_MEMORY = 1, /* other first bytes, as of a memory that was never written */
    NAME_VERSION = 2,      /* a later layout */
    NAME_SHORT = 3,        /* fewer bytes than the image has */
    NAME_LAYOUT = 4,       /* axes, parts and length contradict each other */
    NAME_CHECKSUM = 5,     /* a bit has changed */
    NAME_CONTENT = 6       /* a coefficient is no finite number */
};

typedef struct {
    int axes;              /* 1 or 3 */
    int has_temperature;
    int has_curvature;
    int unit;              /* of the outputs: 0 count, 1 V, 2 m/s^2, 3 g */
    char serial[21];
    uint8_t source[8];     /* first bytes of the SHA-256 of the file of the calibration */
    float k_diagonal[3], k_inverse[3][3], bias[3];
    float t0, low, high, bias_t[3][3], scale_t[3][3];
    float k2[3], k3[3], reach;
} NAME_t;

static inline uint32_t NAME_u32(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static inline float NAME_f32(const uint8_t *b)
{
    union { uint32_t u; float f; } number;
    number.u = NAME_u32(b);
    return number.f;
}

/* Reads an image from the beginning of the bytes; what follows it is not looked at. Nothing is written unless all of it is right. */
static inline int NAME_read(const uint8_t *bytes, size_t length, NAME_t *to)
{
    NAME_t c = {0};
    size_t needed, numbers, place = 40, i;
    uint32_t crc = 0xffffffffu;
    int j, k, linear;
    if (length < 4 || bytes[0] != 'P' || bytes[1] != 'M' || bytes[2] != 'C' || bytes[3] != 'M')
        return NAME_NOT_A_MEMORY;
    if (length < 40)
        return NAME_SHORT;
    if (bytes[4] != 1)
        return NAME_VERSION;
    c.axes = bytes[5];
    if ((c.axes != 1 && c.axes != 3) || bytes[6] > 3 || bytes[7] > 3)
        return NAME_LAYOUT;
    c.has_temperature = bytes[6] & 1;
    c.has_curvature = bytes[6] >> 1;
    c.unit = bytes[7];
    linear = c.axes == 1 ? 2 : 21;
    numbers = (size_t)(linear + c.has_temperature * (3 + 6 * c.axes) + c.has_curvature * (2 * c.axes + 1));
    needed = 40 + 4 * numbers + 4;
    if (NAME_u32(bytes + 8) != needed)
        return NAME_LAYOUT;
    if (length < needed)
        return NAME_SHORT;
    for (i = 0; i < needed - 4; i++) {
        crc ^= bytes[i];
        for (j = 0; j < 8; j++)
            crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
    }
    if ((crc ^ 0xffffffffu) != NAME_u32(bytes + needed - 4))
        return NAME_CHECKSUM;
    for (i = 0; i < numbers; i++)
        if ((NAME_u32(bytes + 40 + 4 * i) & 0x7f800000u) == 0x7f800000u)
            return NAME_CONTENT;
    for (i = 0; i < 20; i++)
        c.serial[i] = (char)bytes[12 + i];
    for (i = 0; i < 8; i++)
        c.source[i] = bytes[32 + i];
#define NAME_NEXT (place += 4, NAME_f32(bytes + place - 4))
    for (j = 0; j < c.axes; j++)
        for (k = 0; k < c.axes; k++) {
            const float element = NAME_NEXT;
            if (j == k)
                c.k_diagonal[j] = element;
        }
    for (j = 0; c.axes == 3 && j < 3; j++)
        for (k = 0; k < 3; k++)
            c.k_inverse[j][k] = NAME_NEXT;
    for (j = 0; j < c.axes; j++)
        c.bias[j] = NAME_NEXT;
    if (c.has_temperature) {
        c.t0 = NAME_NEXT;
        c.low = NAME_NEXT;
        c.high = NAME_NEXT;
        for (j = 0; j < c.axes; j++)
            for (k = 0; k < 3; k++)
                c.bias_t[j][k] = NAME_NEXT;
        for (j = 0; j < c.axes; j++)
            for (k = 0; k < 3; k++)
                c.scale_t[j][k] = NAME_NEXT;
    }
    if (c.has_curvature) {
        for (j = 0; j < c.axes; j++)
            c.k2[j] = NAME_NEXT;
        for (j = 0; j < c.axes; j++)
            c.k3[j] = NAME_NEXT;
        c.reach = NAME_NEXT;
    }
#undef NAME_NEXT
    if (c.axes == 1 && c.k_diagonal[0] == 0.0f)
        return NAME_CONTENT;
    *to = c;
    return NAME_OK;
}
"#;

const APPLY: &str = r#"    d = temperature - c->t0;
    }
    for (i = 0; i < c->axes; i++) {
        v[i] = output[i] - c->bias[i];
        if (c->has_temperature) {
            const float *b = c->bias_t[i], *s = c->scale_t[i];
            v[i] = (v[i] - d * (b[0] + d * (b[1] + d * b[2]))) / (1.0f + d * (s[0] + d * (s[1] + d * s[2])));
        }
        if (c->has_curvature) {
            const float y = v[i] / c->k_diagonal[i], k2 = c->k2[i], k3 = c->k3[i];
            float x = y;
            int step;
            for (step = 0; step < 3; step++)
                x = x - (x * (1.0f + x * (k2 + x * k3)) - y) / (1.0f + x * (2.0f * k2 + 3.0f * k3 * x));
            v[i] = c->k_diagonal[i] * x;
        }
    }
    if (c->axes == 1) {
        acceleration[0] = v[0] / c->k_diagonal[0];
        return 1;
    }
    for (i = 0; i < 3; i++) {
        const float *r = c->k_inverse[i];
        acceleration[i] = r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
    }
    return 1;
}

"#;

fn self_check(text: &mut String, plan: &Plan<'_>, bytes: &[u8]) {
    let (name, check, axes) = (&plan.name, &plan.check, plan.model.axes());
    let n = |v: &f64| literal(*v, true) + "f";
    let row = |v: &[f64]| format!("{{{}}}", v.iter().map(n).collect::<Vec<_>>().join(", "));
    let list = |rows: &[Vec<f64>]| {
        let rows: Vec<String> = rows.iter().map(|r| row(r)).collect();
        format!("{{\n        {}\n    }}", rows.join(",\n        "))
    };
    let image: Vec<String> = bytes
        .chunks(16)
        .map(|line| {
            let line: Vec<String> = line.iter().map(|b| format!("0x{b:02x}")).collect();
            line.join(", ")
        })
        .collect();
    let count = check.outputs.len();
    let _ = write!(
        text,
        "/* 0 when the image is read and all vectors agree within {} m/s^2, -1 when it is not read, else the number of the first that\n   \
         does not agree. */\nstatic inline int {name}_self_check(void)\n{{\n    static const uint8_t image[{}] = {{\n        {}\n    }};\n    \
         static const float output[{count}][{axes}] = {};\n    static const float temperature[{count}] = {};\n    \
         static const float expected[{count}][{axes}] = {};\n    {name}_t c;\n    int v, i;\n    \
         if ({name}_read(image, sizeof image, &c) != {name}_OK)\n        return -1;\n    for (v = 0; v < {count}; v++) {{\n        \
         float a[{axes}];\n        if (!{name}_apply(&c, output[v], temperature[v], a))\n            return v + 1;\n        \
         for (i = 0; i < {axes}; i++) {{\n            const float e = a[i] - expected[v][i];\n            \
         if (!(e <= {bound} && e >= -{bound}))\n                return v + 1;\n        }}\n    }}\n    return 0;\n}}\n\n",
        literal(check.single_bound, true),
        bytes.len(),
        image.join(",\n        "),
        list(&check.outputs),
        row(&check.temperatures),
        list(&check.accelerations),
        bound = n(&check.single_bound),
    );
}
