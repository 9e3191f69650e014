"""A batch of rides from Python, to be timed beside the same batch from Rust.

python python/bench_batch.py 1000 20
"""

import resource
import sys
import time

import twinhub

rides, duration_s = int(sys.argv[1]), float(sys.argv[2])
begun = time.monotonic()
found = twinhub.batch(seeds=range(rides), set={"duration_s": duration_s, "law": "scheduled"})
spent = time.monotonic() - begun
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
effort = found["rider_effort_rms_nm"].mean()
print(f"{rides} rides of {duration_s} s: {spent:.2f} s; mean effort {effort:.4f} Nm; at most {memory} MB")
