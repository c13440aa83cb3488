"""Writes the Parquet and Arrow files beside this script (pyarrow 26, polars 2, pandas 3).

    python write.py

`tests/columnar.rs` has the same formulas.
"""

import datetime
from decimal import Decimal
from pathlib import Path

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
from pyarrow import feather

HERE = Path(__file__).parent
ROWS = range(50)
LONG = "a word of more than twelve bytes"

KINDS = {
    "f64": pa.array([i / 2 - 3 for i in ROWS], pa.float64()),
    "f32": pa.array([i / 4 for i in ROWS], pa.float32()),
    "f16": pa.array(np.array([i / 8 for i in ROWS], np.float16)),
    "i8": pa.array([i - 25 for i in ROWS], pa.int8()),
    "u8": pa.array([i + 200 for i in ROWS], pa.uint8()),
    "i16": pa.array([-300 * i for i in ROWS], pa.int16()),
    "u16": pa.array([60000 + i for i in ROWS], pa.uint16()),
    "i32": pa.array([-100000 * i for i in ROWS], pa.int32()),
    "u32": pa.array([4000000000 + i for i in ROWS], pa.uint32()),
    "i64": pa.array([-(10**12) * i for i in ROWS], pa.int64()),
    "u64": pa.array([2**63 + 4096 * i for i in ROWS], pa.uint64()),
    "bool": pa.array([i % 3 == 0 for i in ROWS]),
    "d9": pa.array([Decimal(125 * i).scaleb(-2) for i in ROWS], pa.decimal128(9, 2)),
    "d18": pa.array([Decimal(-i).scaleb(-3) for i in ROWS], pa.decimal128(18, 3)),
    "d38": pa.array([Decimal(10**20 * i + 1).scaleb(-10) for i in ROWS], pa.decimal128(38, 10)),
}

OTHERS = {
    "word": pa.array([f"w{i % 3}" for i in ROWS]),
    "large": pa.array([f"{LONG} {i % 4}" for i in ROWS], pa.large_string()),
    "category": pa.DictionaryArray.from_arrays([i % 2 for i in ROWS], ["no", "yes", "never"]),
    "day": pa.array([datetime.date(2026, 1, 1 + i % 28) for i in ROWS]),
    "time": pa.array([datetime.datetime(2026, 1, 1, i % 24) for i in ROWS]),
    "list": pa.array([[i, i] for i in ROWS]),
    "pair": pa.array([{"x": i, "y": 1.0} for i in ROWS]),
    "bytes": pa.array([b"b" for _ in ROWS]),
}

MISSING = {
    "x": pa.array([None if i % 7 == 3 else float(i) for i in ROWS]),
    "y": pa.array([float(-i) for i in ROWS]),
    "word": pa.array([None if i == 20 else "rare" if i % 7 == 3 else f"w{i % 2}" for i in ROWS]),
    "flag": pa.array([None if i == 30 else i % 2 == 0 for i in ROWS]),
}

LARGE = {
    "id": pa.array([1, 2**53, 2**53 + 1, None, -(2**53) - 3], pa.int64()),
    "x": pa.array([0.5, 1, 2, 3, None]),
    "u64": pa.array([2**64 - 1, 2**63, 0, 1, 2], pa.uint64()),
    "whole": pa.array([5, 2**53 + 1, 4, 3, 2], pa.decimal128(20, 0)),
    "small": pa.array([2**53, 2, 3, 4, 5], pa.int64()),
    "took": pa.array([1, 2, 3, 4, 5], pa.duration("ms")),
}


DECIMALS = {
    "narrow": pa.array([None if i == 3 else Decimal(125 * i - 1000).scaleb(-2) for i in ROWS],
                       pa.decimal256(20, 2)),
    "whole": pa.array([2**53 + 1 if i == 4 else -i for i in ROWS], pa.decimal256(38, 0)),
    "wide": pa.array([Decimal(i) for i in ROWS], pa.decimal256(39, 0)),
}


def write(name, table, **options):
    pq.write_table(table, HERE / f"{name}.parquet", row_group_size=20, **options)


def main():
    kinds = pa.table(KINDS | OTHERS)
    write("kinds", kinds, compression="none")
    feather.write_feather(kinds, HERE / "kinds.arrow", compression="uncompressed", chunksize=20)
    missing = pa.table(MISSING)
    write("missing", missing, compression="none", use_dictionary=False, data_page_version="2.0")
    feather.write_feather(missing, HERE / "missing.arrow", compression="uncompressed", chunksize=20)
    large = pa.table(LARGE)
    pq.write_table(large, HERE / "large.parquet", row_group_size=2, compression="none")
    feather.write_feather(large, HERE / "large.arrow", compression="uncompressed", chunksize=2)
    doubles = pa.table({"f64": KINDS["f64"]})
    pq.write_table(doubles, HERE / "checked.parquet", compression="none", use_dictionary=False,
                   write_page_checksum=True)
    decimals = pa.table(DECIMALS)
    feather.write_feather(decimals, HERE / "decimals.arrow", compression="uncompressed")
    pq.write_table(decimals, HERE / "decimals.parquet", compression="none")
    nulls = pa.table({"nothing": pa.nulls(12345)})
    feather.write_feather(nulls, HERE / "nulls.arrow", compression="uncompressed")
    numbers = pa.table({name: KINDS[name] for name in ("f64", "i32")} | {"word": OTHERS["word"]})
    for codec in ("snappy", "gzip", "zstd", "lz4", "brotli"):
        write(codec, numbers, compression=codec)
    encodings = {"f64": "BYTE_STREAM_SPLIT", "i32": "DELTA_BINARY_PACKED", "word": "PLAIN"}
    write("encodings", numbers, compression="snappy", use_dictionary=False,
          column_encoding=encodings, data_page_version="2.0")
    for codec in ("lz4", "zstd"):
        feather.write_feather(numbers, HERE / f"{codec}.feather", compression=codec, chunksize=20)
    feather.write_feather(numbers, HERE / "version1.feather", version=1)
    frame = pl.from_arrow(numbers).with_columns(
        long=pl.Series([f"{LONG} {i % 4}" for i in ROWS]),
        category=pl.Series([f"c{i % 3}" for i in ROWS], dtype=pl.Categorical),
    )
    frame.write_parquet(HERE / "polars.parquet", row_group_size=20)
    frame.write_ipc(HERE / "polars.arrow", compression="zstd")
    index = pd.Index([7 * i for i in ROWS], name="the key")
    frame = pa.Table.from_pandas(pd.DataFrame({"x": [i / 2 for i in ROWS]}, index=index))
    pq.write_table(frame, HERE / "pandas.parquet", compression="none")
    with pa.ipc.new_file(HERE / "pandas.arrow", frame.schema) as writer:
        writer.write_table(frame)


main()
