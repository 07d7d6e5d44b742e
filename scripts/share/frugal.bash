# Completion for bash. Commands and options come from the program's own --help, cameras and devices from the program.

_frugal_words()
{
  mapfile -t COMPREPLY < <(compgen -W "$1" -- "$2")
}

# The scene that the command line names, if any.
_frugal_scene()
{
  local word
  for word in "${COMP_WORDS[@]:2}"; do
    [[ $word == *.@(glb|gltf|json) && -r $word ]] && printf '%s\n' "$word" && return
  done
}

# Complete the value of an option; fails for one that takes a file, or that is unknown here.
_frugal_value()
{
  case $1 in
    --format) _frugal_words 'png jpg exr hdr' "$2" ;;
    --tone-map) _frugal_words 'none filmic pbr-neutral' "$2" ;;
    --lighting) _frugal_words 'pbr phong' "$2" ;;
    --methods) _frugal_words 'auto exact' "$2" ;;
    --primary) _frugal_words 'auto raster rays' "$2" ;;
    --environment-light) _frugal_words 'auto none ambient sh sh-ao sampled' "$2" ;;
    --shadows) _frugal_words 'none map pcf pcss hybrid rays area auto' "$2" ;;
    --reflections | --deep-reflections) _frugal_words 'none environment cube box impostor snapshot planar candidates mixed hybrid rays' "$2" ;;
    --cube-size | --near-radius) _frugal_words 'auto' "$2" ;;
    --background) _frugal_words 'environment transparent' "$2" ;;
    --verify) _frugal_words 'all' "$2" ;;
    --exposure) _frugal_words 'auto' "$2" ;;
    --frames) _frugal_words 'all' "$2" ;;
    --bit-depth) _frugal_words '8 16' "$2" ;;
    --aov)
      local before=''
      [[ $2 == *,* ]] && before=${2%,*},
      _frugal_words "${before}depth ${before}position ${before}normal ${before}albedo ${before}object
        ${before}primitive ${before}material ${before}shadow ${before}reflection" "$2"
      ;;
    --only)
      _frugal_words "shadows reflections geometry
        $("$program" stability --list 2>/dev/null | sed 's/^[a-z]*  *\([a-z-]*\) .*/\1/')" "$2"
      ;;
    --device)
      _frugal_words "cpu gpu
        $("$program" devices --no-self-test 2>/dev/null | sed -n 's/^\([0-9]*\)  .*/\1/p')" "$2"
      ;;
    --camera)
      local cameras=fit scene
      scene=$(_frugal_scene)
      [[ $scene ]] && cameras=$("$program" render "$scene" --list-cameras 2>/dev/null | cut -f 1)
      _frugal_words "$cameras" "$2"
      ;;
    --light-shadows)
      local lights='' scene
      scene=$(_frugal_scene)
      [[ $scene ]] && lights=$("$program" info "$scene" 2>/dev/null | sed -n "s/^\(lights\)\{0,1\}  *\(#[0-9]*\) '.*/\2=/p")
      _frugal_words "$lights" "$2"
      ;;
    -s | --size | --crop | -n | --samples | --quality | --compression | --snapshot-from) ;;
    --environment-rotation | --environment-intensity | --ambient) ;;
    --max-depth | --max-roughness | --threads | --seed | --max-memory | --max-image-pixels) ;;
    *) return 1 ;;
  esac
}

_frugal()
{
  local program=${COMP_WORDS[0]} current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    _frugal_words "--help --version
      $("$program" --help 2>/dev/null | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\) .*/\1/p')" "$current"
  elif [[ $current == -* ]]; then
    _frugal_words "$("$program" "${COMP_WORDS[1]}" --help 2>/dev/null |
      sed -n 's/^ *\(-[a-zA-Z], \)\{0,1\}\(--[a-z][-a-z0-9]*\).*/\2/p')" "$current"
  elif ! _frugal_value "$previous" "$current"; then
    compopt -o default 2>/dev/null  # file names
  fi
}

complete -F _frugal frugal
