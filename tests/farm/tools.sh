# What the scripts of the engines share.

# until_true SECONDS COMMAND...: waits for it.
until_true() {
    local deadline=$((SECONDS + $1))
    shift
    until "$@"; do
        ((SECONDS < deadline)) || { echo "waited in vain for: $*" >&2; return 1; }
        sleep 0.2
    done
}

# same ONE FOLDER: every picture of one run is there, with the same bytes.
same() {
    local picture
    for picture in "$1"/image.*; do cmp "$picture" "$2/${picture##*/}"; done
}

# left_in FOLDER: the frames that its status says are not done.
left_in() {
    local code=0
    "$niji" farm status "$1" -q 2>/dev/null || code=$?
    [ "$code" = 6 ] || { echo "status of $1: found code $code, expected 6" >&2; return 1; }
}

# lose FOLDER: frame 5 is gone, frame 9 has another byte in its middle.
lose() {
    rm "$1/image.0005.exr"
    local damaged=$1/image.0009.exr
    printf '\377\377' | dd of="$damaged" bs=1 seek=$(($(stat -c %s "$damaged") / 2)) conv=notrunc status=none
}
