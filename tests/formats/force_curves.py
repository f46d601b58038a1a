"""Writes force curves as JPK, Nanosurf and NanoScope lay them out, and reads them by libraries that share no code with palpate.

Call: force_curves.py FOLDER. Prints for each file what its library reads: curves, each a list of stretches in the order of time with
`way_m` (towards the specimen), `force_N`, and the spring constant.
"""

import json
import pathlib
import sys
import zipfile

import numpy as np

POINTS = 300
SPRING = 0.05
# Counts of the deflection on the way in and back, and of the height, by the curve.
RNG = np.random.default_rng(1)


def counts(curve):
    depth = np.maximum(np.arange(POINTS) - 150 - 10 * curve, 0)
    forward = (40 * depth + RNG.integers(-20, 20, POINTS)).astype(int)
    return forward, forward[::-1] + RNG.integers(-20, 20, POINTS)


def jpk_channel(key, encoder, conversions, default):
    """Properties of a channel; each conversion is a slot, the slot below, a factor, an offset and a unit."""
    kind, factor, offset, unit = encoder
    lines = [
        f"{key}.type=integer-data", f"{key}.encoder.type={kind}", f"{key}.encoder.scaling.style=offsetmultiplier",
        f"{key}.encoder.scaling.multiplier={factor}", f"{key}.encoder.scaling.offset={offset}", f"{key}.encoder.scaling.unit.unit={unit}",
        f"{key}.conversion-set.conversions.base=volts", f"{key}.conversion-set.conversions.default={default}",
        f"{key}.conversion-set.conversion.volts.defined=false",
    ]
    for slot, below, factor, offset, unit in conversions:
        at = f"{key}.conversion-set.conversion.{slot}"
        lines += [
            f"{at}.name={slot}", f"{at}.defined=true", f"{at}.type=simple", f"{at}.base-calibration-slot={below}",
            f"{at}.scaling.multiplier={factor}", f"{at}.scaling.offset={offset}", f"{at}.scaling.unit.unit={unit}",
        ]
    return lines


def jpk(path, curves):
    shared = ["force-segment-header-info.0.settings.style=extend", "force-segment-header-info.1.settings.style=retract"]
    shared += [f"force-segment-header-info.{n}.settings.segment-settings.{k}={v}" for n in (0, 1) for k, v in (("duration", "0.5"), ("z-start", "0"), ("z-end", "1e-6"))]
    shared += ["force-segment-header-info.0.approach-id=1", "force-segment-header-info.1.approach-id=1"]
    shared += jpk_channel("lcd-info.0", ("signedinteger", 1e-8, 50.0, "V"), [("nominal", "volts", -1e-6, 1e-4, "m"), ("calibrated", "nominal", 0.7, 0.0, "m")], "calibrated")
    shared += jpk_channel("lcd-info.1", ("signedshort", 3e-4, -0.007, "V"), [("distance", "volts", 7e-8, 0.0, "m"), ("force", "distance", SPRING, 0.0, "N")], "force")
    whole = ["force-scan-series.header.position-index=0", "force-scan-series.header.position.x=0", "force-scan-series.header.position.y=0"]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("header.properties", "\n".join(["jpk-data-file=spm-forcefile", "file-format-version=2.0", *whole]))
        file.writestr("shared-data/header.properties", "\n".join(shared))
        single = len(curves) == 1
        if not single:
            file.writestr("index/", "")
        for number, (forward, back) in enumerate(curves):
            top = "" if single else f"index/{number}/"
            if not single:
                file.writestr(top, "")
                file.writestr(top + "header.properties", "\n".join(whole))
            file.writestr(top + "segments/", "")
            way = np.arange(POINTS) * 1_000_000
            for segment, (height, deflection) in enumerate([(way, forward), (way[::-1], back)]):
                at = f"{top}segments/{segment}/"
                file.writestr(at, "")
                lines = [
                    f"force-segment-header.force-segment-header-info.*={segment}", f"force-segment-header.num-points={POINTS}",
                    "force-segment-header.duration=0.5", "force-segment-header.time-stamp=2024-05-31 14\\:03\\:05.000 +0200",
                    "channels.list=height vDeflection",
                ]
                for place, (name, values, kind) in enumerate([("height", height, ">i4"), ("vDeflection", deflection, ">i2")]):
                    lines += [f"channel.{name}.lcd-info.*={place}", f"channel.{name}.data.file.name=channels/{name}.dat", f"channel.{name}.data.num-points={POINTS}"]
                    file.writestr(f"{at}channels/{name}.dat", np.asarray(values).astype(kind).tobytes())
                file.writestr(at + "segment-header.properties", "\n".join(lines))


def read_jpk(path):
    import afmformats

    def stretch(curve, part):
        return {"way_m": (-part["height (piezo)"]).tolist(), "force_N": part["force"].tolist()}

    curves = afmformats.load_data(path)
    return [{"spring": curve.metadata["spring constant"], "stretches": [stretch(curve, curve.appr), stretch(curve, curve.retr)]} for curve in curves]


def nid(path, curves):
    lines = ["[DataSet]", "Version=2", "GroupCount=3"]
    frames = ["Spec forward", "Spec backward"]
    for group, frame in enumerate(frames):
        lines += [f"Gr{group}-Name={frame}", f"Gr{group}-ID={group + 1}", f"Gr{group}-Count=2"]
    # An analysis of Nanosurf's own, as its files have them.
    lines += ["Gr2-Name=SlopeOut00", "Gr2-ID=256", "Gr2-Count=1", "Gr2-Ch0=DataSet-2:0"]
    lines += [f"Gr{group}-Ch{channel}=DataSet-{group}:{channel}" for group in (0, 1) for channel in (0, 1)]
    lines += ["", "[DataSet-Info]", "-- Spec --=--------", "Data points=300", ""]
    lines += ["[DataSet\\Calibration\\Cantilever]", "Name=A", "Manufacturer=B", "PropCount=1", f"Prop0=D[{SPRING}]*[N/m]", ""]
    lines += ["[DataSet\\Calibration\\Scanhead]", "In0=0,Channel0,Deflection,N,2e-06,0", "In5=5,TipSignalDC,Deflection,m,7e-07,0", ""]
    settings = {"FwModTime": "D[0.5]*[s]", "BwModTime": "D[0.25]*[s]", "FwPauseTime": "D[0]*[s]", "BwPauseTime": "D[0]*[s]", "FwModRange": "D[1e-06]*[m]", "BwModRange": "D[-1e-06]*[m]", "FwModStopValue": "D[1e-08]*[N]"}
    lines += ["[DataSet\\Parameters\\Spectroscopy]", *(f"{key}={value}" for key, value in settings.items()), ""]
    numbers = b""
    # The second curve met its setpoint early: fewer numbers on the way in.
    lengths = [POINTS - 20 * curve for curve in range(len(curves))]
    way = np.arange(POINTS) * 5_000_000 - 2**30
    for group, frame in enumerate(frames):
        for channel, (signal, unit, least, span) in enumerate([("Deflection", "N", -2e-6, 4e-6), ("Z-Axis Sensor", "m", -1.4e-5, 2.8e-5)]):
            lines += [
                f"[DataSet-{group}:{channel}]", "Version=3", f"Points={POINTS}", f"Lines={len(curves)}", f"Frame={frame}", f"CurLine={len(curves) - 1}",
                "Dim0Name=Z-Axis", "Dim0Unit=m", "Dim0Range=1e-6", "Dim0Min=0", "Dim1Name=SpecPoint", "Dim1Unit=", "Dim1Range=1", "Dim1Min=1",
                f"Dim2Name={signal}", f"Dim2Unit={unit}", f"Dim2Range={span}", f"Dim2Min={least}",
                "SaveMode=Binary", "SaveBits=32", "SaveSign=Signed", "SaveOrder=Intel",
            ]
            for row, (forward, back) in enumerate(curves):
                length = lengths[row] if group == 0 else POINTS
                lines += [f"LineDim{row}Range=1e-6", f"LineDim{row}Min=0", f"LineDim{row}Points={length}"]
                # The way back runs along the same axis: its last number was recorded first.
                values = way if channel else (forward, back[::-1])[group] * 10_000
                kept = np.zeros(POINTS, "<i4")
                kept[:length] = values[:length]
                numbers += kept.tobytes()
            lines += [""]
    lines += ["[DataSet-2:0]", "Version=3", "Points=2", "Lines=1", "Frame=SlopeOut00", "CurLine=0", "Dim0Unit=m", "Dim0Range=1", "Dim0Min=0"]
    lines += ["Dim1Unit=", "Dim1Range=1", "Dim1Min=1", "Dim2Name=NameZ4", "Dim2Unit=m", "Dim2Range=1", "Dim2Min=0"]
    lines += ["SaveMode=Binary", "SaveBits=32", "SaveSign=Signed", "SaveOrder=Intel", ""]
    path.write_bytes("\r\n".join([*lines, "", ""]).encode("latin-1") + b"#!" + numbers + bytes(8))


def read_nid(path):
    from NSFopen.read import read

    file = read(str(path))
    spec = file.data["Spec"]
    curves = []
    for row in range(len(spec["Forward"]["Deflection"])):
        def stretch(direction, order):
            signals = spec[direction]
            return {"way_m": np.asarray(signals["Z-Axis Sensor"][row])[order].tolist(), "force_N": np.asarray(signals["Deflection"][row])[order].tolist()}
        curves.append({"spring": file.param.Tip.Prop0["Value"], "stretches": [stretch("Forward", slice(None)), stretch("Backward", slice(None, None, -1))]})
    return curves


def nanoscope(path, curves):
    offset = 8192
    side = max(1, int(len(curves) ** 0.5))
    header = ["\\*Force file list", "\\Version: 0x09400103", "\\*Equipment list", "\\Microscope: MultiMode 8", "\\*Scanner list", "\\@Sens. Zsens: V 20.5 nm/V", "\\*Ciao scan list"]
    header += [f"\\Operating mode: {'Force' if len(curves) == 1 else 'Force Volume'}", "\\@Sens. DeflSens: V 60.25 nm/V", "\\PeakForce Capture: Never", "\\PFT Freq: 1.0 KHz", "\\Peak Force Amplitude: 100", "\\Sample Points: 128", "\\Sync Distance New: 0", "\\Sync Distance QNM: 0", f"\\Samps/line: {side}"]
    header += ["\\*Ciao force list", "\\Scan rate: 1.0", "\\Forward vel.: 100.0", "\\Reverse vel.: 200.0", f"\\Samps/line: {POINTS} {POINTS}", f"\\force/line: {side}", "\\Trigger mode: Relative", "\\@4:Trig threshold Deflection: V [Sens. DeflSens] (0.0003750000 V/LSB) 1.0 V"]
    if len(curves) > 1:
        header += ["\\*Ciao image list", f"\\Data length: {side * side * 2}", f"\\Samps/line: {side}", f"\\Number of lines: {side}", "\\Data offset: 0", "\\Scan Size: 1 1 nm", "\\Bytes/pixel: 2"]
    length = len(curves) * 2 * POINTS * 2
    header += ["\\*Ciao force image list", f"\\Data offset: {offset}", f"\\Data length: {length}", "\\Bytes/pixel: 2", f"\\Samps/line: {POINTS} {POINTS}", f"\\Spring Constant: {SPRING}"]
    header += ['\\@4:Image Data: S [DeflectionError] "Deflection Error"', "\\@4:Z scale: V [Sens. DeflSens] (0.0003750000 V/LSB) 24.57600 V", "\\@4:Ramp size: V [Sens. Zsens] (0.006713867 V/LSB) 50.00000 V", "\\*File list end"]
    numbers = b"".join(np.concatenate([forward[::-1], back]).astype("<i2").tobytes() for forward, back in curves)
    path.write_bytes(("\r\n".join(header) + "\r\n\x1a").encode("latin-1").ljust(offset, b"\0") + numbers)


def read_nanoscope(path):
    from pyfmreader.nanosc.loadnanosccurve import loadNANOSCcurve
    from pyfmreader.nanosc.parsenanoscheader import parseNANOSCheader

    header = parseNANOSCheader(str(path))
    # The library cuts a first sample that it takes for a marker, and takes the last of the way back off both.
    raw = []
    for number in range(header["Entry_tot_nb_curve"]):
        curve = loadNANOSCcurve(number, header)
        (_, forward), (_, back) = curve.extend_segments[0], curve.retract_segments[0]
        scale = header["defl_sens_nmbyV"] * 1e-9 * header["spring_const_Nbym"]
        stretches = []
        # Both stretches run from far off to the specimen.
        for stretch, order in ((forward, slice(None)), (back, slice(None, None, -1))):
            values = stretch.segment_formated_data
            stretches.append({"way_m": values["height"][order].tolist(), "force_N": (values["vDeflection"] * scale)[order].tolist()})
        raw.append({"spring": header["spring_const_Nbym"], "stretches": stretches})
    return raw


WRITERS = [
    ("curve.jpk-force", jpk, read_jpk, 1), ("map.jpk-force-map", jpk, read_jpk, 3), ("curve.nid", nid, read_nid, 2),
    ("curve.spm", nanoscope, read_nanoscope, 1), ("volume.spm", nanoscope, read_nanoscope, 4),
]


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    found = {}
    for name, write, read, number in WRITERS:
        write(folder / name, [counts(curve) for curve in range(number)])
        found[name] = read(folder / name)
    print(json.dumps(found))


main()
