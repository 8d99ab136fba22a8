#!/usr/bin/env bash
# The code of a running robot and of a ball as `saltus export gait`, and that of `saltus export policy`, without the head that names
# the robot, and without a policy's table.
#
#     bash controller/c/filled.sh float|double FOLDER
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
if [ "$1" = float ]; then
    words='s/@REAL@/float/; s/@SUFFIX@/x##f/; s/@SQRT@/sqrtf/; s/@ABS@/fabsf/; s/@GREATEST@/FLT_MAX/; s/@GREAT@/12582912.0f/; s/@BITS@/uint32_t/'
else
    words='s/@REAL@/double/; s/@SUFFIX@/x/; s/@SQRT@/sqrt/; s/@ABS@/fabs/; s/@GREATEST@/DBL_MAX/; s/@GREAT@/6755399441055744.0/; s/@BITS@/uint64_t/'
fi
for file in saltus_running.h saltus_running.c saltus_ball.h saltus_ball.c saltus_policy.h; do
    sed "s/@HEADER@//; s/@DATA@//; $words" "controller/c/$file" >"$2/$file"
done
