# Removes the counts of earlier runs: -DCOUNTS=PATTERN below the build folder.

file(GLOB_RECURSE counts "${COUNTS}")
if(counts)
    file(REMOVE ${counts})
endif()
